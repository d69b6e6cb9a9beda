"""Analysis of a network before anything moves."""
