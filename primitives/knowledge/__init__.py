"""World model of the robot: a map, places, and a section for each domain."""
