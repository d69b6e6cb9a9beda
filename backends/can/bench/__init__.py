"""A test stand: simulated drives in front of a simulated robot, and what can go wrong with them."""
