"""A base that yaws and tilts when its arm moves."""
