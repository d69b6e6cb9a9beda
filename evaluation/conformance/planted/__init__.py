"""Mutants that the kit has to find."""
