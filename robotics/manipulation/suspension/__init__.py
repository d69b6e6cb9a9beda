"""A base that yaws and leans when its arm moves."""
