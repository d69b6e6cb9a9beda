"""Spines, gaps and labels on shelves."""
