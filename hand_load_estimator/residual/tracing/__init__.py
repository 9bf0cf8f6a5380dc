"""From a residual to effects: hypotheses compared on data that they were not fitted to."""
