"""Grid maps, and what stands on them."""
