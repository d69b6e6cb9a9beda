"""Texts of users in diagrams."""

from __future__ import annotations


def plain(text: str) -> str:
    """Return a text that matplotlib draws as it is: between two dollar signs it would read mathematics."""
    return text.replace("$", r"\$")
