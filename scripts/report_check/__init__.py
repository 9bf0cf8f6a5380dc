"""A report of `hand_load diagnose` looked at in a real browser: screenshots, nothing cut."""
