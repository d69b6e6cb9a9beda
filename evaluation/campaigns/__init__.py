"""Campaigns: many runs of one task in parallel, each written to disk when it has ended."""
