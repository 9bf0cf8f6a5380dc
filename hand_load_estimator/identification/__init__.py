"""Identify an arm from recordings (eq. 11): what is fit, to what, and what it leaves."""
