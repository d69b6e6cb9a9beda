"""Bring-up of a robot by ROS 2: its topics, its stop on silence, its signs and units."""
