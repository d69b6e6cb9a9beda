"""From pixels to tags, labels, spines and gaps."""
