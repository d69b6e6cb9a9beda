"""Recorded bags in place of the topics on the air."""
