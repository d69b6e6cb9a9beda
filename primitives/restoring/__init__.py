"""How everything comes back to where it was, measured."""
