"""Packing and reading of ROS messages."""
