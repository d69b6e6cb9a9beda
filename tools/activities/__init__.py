"""Commands for household activities."""
