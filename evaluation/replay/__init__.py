"""Recorded logs of wheels, gyros and satellites, played to the robot's outdoor localization."""
