"""Bags of ROS 2 and ROS 1: read, also where they are damaged, and written."""
