"""Comparison of a robot's file with the topics that are on the air, without sending anything."""
