"""What a controller does with the load: limits, motions, collision thresholds; no ROS."""
