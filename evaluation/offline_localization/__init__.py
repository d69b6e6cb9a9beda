"""Replay of recorded logs of wheels, gyros and GNSS to the robot's outdoor localization."""
