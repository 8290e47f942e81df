"""How images, estimates and ground truth are packed into ROS messages, and read back."""
