"""Files as typed values, and what is wrong with them."""
