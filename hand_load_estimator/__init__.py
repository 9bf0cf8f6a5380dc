"""Estimate the load on a robot's hand, with variance, and use it."""

__version__ = '0.1.0'
