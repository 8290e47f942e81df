"""The cable: its state, geometry, movement, how it looks, and the tracker. Knows no ROS."""
