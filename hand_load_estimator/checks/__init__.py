"""What `hand_load check` looks at, one module per concern; recording_check.py puts it together."""
