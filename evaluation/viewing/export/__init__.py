"""Export of runs and campaigns to the formats of other programs."""
