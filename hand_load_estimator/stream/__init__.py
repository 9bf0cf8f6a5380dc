"""From messages to motion samples: what is let through, and what is counted as unusable."""
