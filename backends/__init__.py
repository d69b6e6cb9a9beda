"""Robots: capabilities, Robot, and the backends behind it."""

if __name__ != "handcart.backends":
    raise ImportError("import handcart.backends: the folder alone would be a second copy of it")
