"""Objects with tags in physics."""
