"""What the robot's sensors read in physics."""
