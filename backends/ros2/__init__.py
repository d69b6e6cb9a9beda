"""Robots that speak ROS 2, by topics; rclpy is imported only when one is driven."""
