"""What is wrong with the times, the fixes and the axes of a recorded log."""
