"""What stands in ROS messages, and how it is packed and read."""
