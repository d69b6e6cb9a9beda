"""Where a base is on open ground, by wheels, gyros and satellites."""
