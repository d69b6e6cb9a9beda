"""What the robot knows of objects and surfaces: the section of the world model, names, places, views."""
