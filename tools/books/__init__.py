"""Commands for books."""
