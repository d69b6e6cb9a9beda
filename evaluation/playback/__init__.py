"""A run, kept so that it can be looked at again: who writes that down, and who reads it."""
