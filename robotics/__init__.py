"""The mathematics: arrays in, arrays or named tuples out; no I/O, no framework."""

if __name__ != "handcart.robotics":
    raise ImportError("import handcart.robotics: the folder alone would be a second copy of it")
