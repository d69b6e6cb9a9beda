"""Ground truth, metrics, campaigns."""

if __name__ != "handcart.evaluation":
    raise ImportError("import handcart.evaluation: the folder alone would be a second copy of it")
