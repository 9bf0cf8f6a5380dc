"""ROS 2 nodes: thin shells around the package; the only room with rclpy."""
