"""People and carts that walk through a simulated world."""
