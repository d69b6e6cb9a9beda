"""Finding, picking and placing objects that a file describes."""
