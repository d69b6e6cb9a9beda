"""Detection of tags, labels, spines and gaps in images."""
