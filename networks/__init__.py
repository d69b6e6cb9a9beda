"""Decisions of a run: task file, network, planning, coordinator, journal."""

if __name__ != "handcart.networks":
    raise ImportError("import handcart.networks: the folder alone would be a second copy of it")
