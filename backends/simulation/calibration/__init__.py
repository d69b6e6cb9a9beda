"""What is painted on tables, in simulated worlds, for cameras to find."""
