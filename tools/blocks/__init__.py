"""Commands about walls of blocks."""
