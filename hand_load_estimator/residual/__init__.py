"""The residual loop: find what the torque model leaves, trace it to an effect, add it, report."""
