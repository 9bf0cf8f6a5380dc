"""Joint trajectories, and the motions that identify an arm."""
