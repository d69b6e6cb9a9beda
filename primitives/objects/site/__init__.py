"""The robot's place before a surface: what is around it, and how its arm moves there."""
