"""Worlds and maps to drive in, and exact ranges in them."""
