"""Grid maps and their obstacles."""
