"""Landmarks and tags."""
