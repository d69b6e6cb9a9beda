"""Ground truth of maps that EXPLORE drew."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from handcart.evaluation.judging.map_survey import MAX_MISSING_PERCENT, MapSurvey
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import from_boxes

Box = tuple[float, float, float, float, float]
WALLS: Sequence[Box] = [
    (2.0, 0.0, 0.0, 4.2, 0.1),
    (2.0, 3.0, 0.0, 4.2, 0.1),
    (0.0, 1.5, np.pi / 2, 3.0, 0.1),
    (4.0, 1.5, np.pi / 2, 3.0, 0.1),
]
SHELF: Box = (2.0, 1.5, 0.0, 1.0, 0.3)


def untrue(true: Sequence[Box], drawn: Sequence[Box]) -> list[str]:
    """Return the objections to a map with the boxes `drawn`, of a world with the boxes `true`."""
    solids = [SimpleNamespace(outline=box, reaches=lambda height: True) for box in true]
    robot = SimpleNamespace(
        range_sensor_height=0.25,
        spec=SimpleNamespace(footprint_shape=SimpleNamespace(inscribed=0.2)),
    )
    run = SimpleNamespace(world=SimpleNamespace(solids=solids), robot=robot, world_T_map=Pose2(0.0, 0.0, 0.0))
    grid = from_boxes(drawn, 0.05, (-0.5, -0.5), (5.0, 4.0))
    made = SimpleNamespace(grid=grid, built=SimpleNamespace(poses=np.array([[1.0, 0.7, 0.0]])))
    primitive = SimpleNamespace(evidence=SimpleNamespace(maps={"explored": made}), radius_m=np.inf)
    survey: Any = SimpleNamespace(run=run)
    return MapSurvey.effects["EXPLORE"](survey, SimpleNamespace(primitive=primitive))  # type: ignore[arg-type]


def test_a_map_with_all_walls_is_true() -> None:
    assert untrue([*WALLS, SHELF], [*WALLS, SHELF]) == []


def test_a_map_that_lacks_a_thing_on_the_floor_is_false() -> None:
    """Each wall that it shows is right, and all of the floor is known."""
    (wrong,) = untrue([*WALLS, SHELF], WALLS)
    assert wrong.startswith("the map lacks ")
    assert wrong.endswith(f" % of the walls beside its free floor (at most {MAX_MISSING_PERCENT})")


def test_a_wall_at_another_place_is_false() -> None:
    moved = (*WALLS[:3], (3.7, *WALLS[3][1:]))
    assert any(item.startswith("walls are ") for item in untrue([*WALLS, SHELF], [*moved, SHELF]))
