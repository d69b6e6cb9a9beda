"""Evidence of range scans for a pose on a map, for the pose of a rectangle or a front, and for a motion."""
