"""Nav2 and MoveIt as primitives of handcart."""
