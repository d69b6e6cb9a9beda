"""What stands around the robot, by a world's file."""
