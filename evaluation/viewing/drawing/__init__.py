"""Diagrams and pictures as files."""
