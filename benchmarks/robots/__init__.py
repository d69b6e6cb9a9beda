"""Robots of other people."""
