"""MuJoCo's renderer: pictures for people and for the robot's camera."""
