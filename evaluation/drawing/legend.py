"""Legends of diagrams."""

from __future__ import annotations

from typing import Any


def add_legend(axis: Any, **options: Any) -> None:
    """Name what is drawn on a matplotlib axis; where nothing has a name, there is no legend."""
    if axis.get_legend_handles_labels()[0]:
        axis.legend(**options)
