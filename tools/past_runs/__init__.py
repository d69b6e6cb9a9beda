"""Commands that look at runs that are over."""
