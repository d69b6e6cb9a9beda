"""A size held against what is allowed."""

from __future__ import annotations


def at_most(words: str, size: float, most: float) -> list[str]:
    """Nothing where the size is at most that; else the words, with the size in them, and what is allowed."""
    return [] if size <= most else [f"{words.format(size)} (at most {most:.1f})"]
