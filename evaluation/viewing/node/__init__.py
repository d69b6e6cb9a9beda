"""A run as a node of ROS 2: its state as topics, and the operator's commands as services."""
