"""Where a base is, indoors."""
