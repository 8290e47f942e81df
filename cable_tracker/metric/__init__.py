"""Metres for the controller, and the vehicle's motion for the filter. Knows no ROS."""
