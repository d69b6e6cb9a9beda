"""Manufacturers' descriptions of drives, and features that drives lack."""
