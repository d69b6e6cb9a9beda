"""Events of a run that its observers receive."""
