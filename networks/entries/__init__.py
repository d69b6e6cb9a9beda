"""Entries under `actions:` of a task's file, and the network that conditions span."""
