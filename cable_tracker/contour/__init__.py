"""Level sets and shapes of closed contours. Knows no target and no ROS."""
