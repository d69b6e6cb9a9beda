"""Cameras by ROS 2: pictures and depth."""
