"""A run in three dimensions in the browser, recorded or just now."""
