"""What the robot knows: a map, places, and a section for each domain."""
