"""Household activities of BEHAVIOR-1K: files made from their definitions, and their own judge of a run."""
