"""Recordings of the simulated arm, and the demo."""
