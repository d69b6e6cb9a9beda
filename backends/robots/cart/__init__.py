"""Two wheels, a range sensor, and a deck to put things on."""
