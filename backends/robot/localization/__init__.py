"""Where a robot's base is, by whichever of its sensors tell."""
