"""What stands around the robot in physics."""
