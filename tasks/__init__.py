"""Domains of tasks, each declared in a module; task files and their worlds, as data."""

if __name__ != "handcart.tasks":
    raise ImportError("import handcart.tasks: the folder alone would be a second copy of it")
