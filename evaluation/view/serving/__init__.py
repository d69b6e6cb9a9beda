"""The server behind the page, and who is let in."""
