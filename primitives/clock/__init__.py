"""The clock that a primitive sees: the robot's, never the wall clock."""
