"""Blocks: the building plan, and how they are stacked by landmarks."""
