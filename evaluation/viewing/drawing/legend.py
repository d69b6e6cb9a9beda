"""Legends of diagrams."""

from __future__ import annotations

from typing import Any


def add_legend(axis: Any, **options: Any) -> None:
    """Add a legend to a matplotlib axis if anything on it has a label."""
    if axis.get_legend_handles_labels()[0]:
        axis.legend(**options)
