"""Task files and their worlds: data only."""

if __name__ != "handcart.tasks":
    raise ImportError("import handcart.tasks: the folder alone would be a second copy of it")
