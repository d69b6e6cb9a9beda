"""Whether the robot can stand at the places that it is told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from handcart.files.errors import Finding
from handcart.files.models.loading import Loaded
from handcart.primitives.knowledge.place import Place, Places
from handcart.robotics.navigation.maps.grid_map import GridMap


def place_findings(places: Loaded[Places], grid: GridMap, chart: Path) -> Iterator[Finding]:
    """Places that lie outside the free space of a map; `chart` is the map's file."""
    for name, place in places.value.places.items():
        where = _where(place, grid)
        if where:
            wrong = f"place {name!r} stands {where} {chart.name}; allowed: the free space of the map"
            yield places.finding(("places", name), wrong, at_key=True)


def _where(place: Place, grid: GridMap) -> str:
    """Empty where the place is free."""
    point = np.array([[place.x_m, place.y_m]])
    if not grid.inside(point)[0]:
        return "outside"
    row, column = grid.to_cell(point)[0]
    if grid.occupied[row, column]:
        return "in an obstacle of"
    return "in unknown space of" if grid.unknown[row, column] else ""
