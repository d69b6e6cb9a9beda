"""Benchmarks of robots that speak ROS 2."""
