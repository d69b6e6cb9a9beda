"""Events of a run, for its observers."""
