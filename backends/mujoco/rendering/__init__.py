"""Pictures of MuJoCo's renderer, for people and for the robot's camera."""
