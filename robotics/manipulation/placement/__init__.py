"""Where a base has to stand for a path of its arm's tool."""
