"""Reading YAML with positions and units; the root of errors."""
