"""Tracking of recordings without ROS, and the folders of results that it writes."""
