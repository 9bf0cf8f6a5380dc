"""What a torque model is made of: along recordings, along a stream of samples, in its file."""
