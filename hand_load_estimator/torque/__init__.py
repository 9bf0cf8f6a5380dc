"""What a torque model is made of, along recordings and along a stream of samples."""
