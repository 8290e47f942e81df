"""ROS 2 nodes over the tracker. The only folder that imports rclpy or messages."""
