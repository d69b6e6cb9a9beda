"""Actions of a robot: one primitive per file."""

if __name__ != "handcart.primitives":
    raise ImportError("import handcart.primitives: the folder alone would be a second copy of it")
