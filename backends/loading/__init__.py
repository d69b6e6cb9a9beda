"""Loading of robot files, with the sensors of each kind."""
