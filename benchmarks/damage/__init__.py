"""Damaged files, frames, folders and messages."""
