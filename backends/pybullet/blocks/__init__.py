"""Blocks in Bullet."""
