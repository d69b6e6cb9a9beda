"""The robot as a primitive sees it: a backend, with what is estimated above it."""
