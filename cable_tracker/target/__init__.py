"""A target with an outline: its state, how it looks, how it moves, and the tracker.

Knows no cable and no ROS.
"""
