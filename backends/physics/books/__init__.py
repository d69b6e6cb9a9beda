"""Books in physics."""
