"""The best decisions in a network whose outcomes have probabilities."""
