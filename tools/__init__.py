"""The command line."""

if __name__ != "handcart.tools":
    raise ImportError("import handcart.tools: the folder alone would be a second copy of it")
