"""Accuracy and speed, measured: suites, rivals, bound, scores, pages."""
