"""What ground truth says of tracked seams, and where a base should stand for one."""
