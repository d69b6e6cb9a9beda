"""What range scans say: of a pose on a map, of a rectangle or a front, of a motion."""
