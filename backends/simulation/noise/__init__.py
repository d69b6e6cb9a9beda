"""Seeded noise, each source with a random sequence of its own."""
