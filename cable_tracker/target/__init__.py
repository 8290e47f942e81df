"""A target with an outline: its state, appearance, movement, and the tracker.

Knows no cable and no ROS.
"""
