"""Joint trajectories: motions that identify an arm, and motions that settle a load."""
