"""Commands for seams."""
