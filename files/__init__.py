"""Reading YAML with positions and units; the root of errors."""

if __name__ != "handcart.files":
    raise ImportError("import handcart.files: the folder alone would be a second copy of it")
