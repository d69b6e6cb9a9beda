"""File of objects: its keys, and what is wrong in it."""
