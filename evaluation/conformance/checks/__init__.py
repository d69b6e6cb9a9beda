"""What must hold of a backend."""
