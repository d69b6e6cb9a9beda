"""What a robot can do: one file, one primitive."""

if __name__ != "handcart.primitives":
    raise ImportError("import handcart.primitives: the folder alone would be a second copy of it")
