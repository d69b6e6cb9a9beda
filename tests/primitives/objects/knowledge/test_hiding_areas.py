"""Obstacles on the map that stand on a surface, and those that are the surface."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.pick import Pick
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

from ..fetching import TASK, changed, scene_of

AREA = "surfaces:\n  pallet: {x_m: 4.0, y_m: 1.2, height_m: 0.15, size_m: [0.5, 0.5]}\n"
KNOWN = "parcel_1: {kind: parcel, on: table_a, x_m: 1.9, y_m: 3.65,"
ON_IT = "parcel_1: {kind: parcel, on: pallet, x_m: 3.9, y_m: 1.2,"
LIDAR_M = 0.25
SCREEN_M = (0.24, 0.03, 0.62)


def before_a_pallet(folder: Path, screen_y: float = 1.36) -> Rig:
    """Return a robot at home; a pallet carries a parcel and a mapped screen, which the lidar sees."""
    screen = {"name": "screen", "x_m": 3.9, "y_m": screen_y, "size_m": list(SCREEN_M)}
    pallet = {"name": "pallet", "x_m": 4.0, "y_m": 1.2, "size_m": [0.5, 0.5, 0.15]}
    data = yaml.safe_load((TASK / "world.yaml").read_text(encoding="utf-8"))
    data["furniture"] += [pallet, screen]
    data["objects"][0] |= {"x_m": 3.9, "y_m": 1.2, "height_m": 0.15, "sigma_mm": 5}
    world = folder / "world.yaml"
    world.write_text(yaml.safe_dump(data), encoding="utf-8")
    picture = cv2.imread(str(TASK / "map.png"), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    rows, columns = np.indices(picture.shape)
    at_x, at_y = 0.02 * columns - 0.25, 0.02 * (len(picture) - 1 - rows) - 0.25
    picture[(abs(at_x - 3.9) < SCREEN_M[0] / 2) & (abs(at_y - screen_y) < 0.02)] = 0
    cv2.imwrite(str(folder / "map.png"), picture)
    objects = changed(folder, "objects.yaml", ("surfaces:\n", AREA), (KNOWN, ON_IT))
    known_map = changed(folder, "map.yaml")
    return build_rig(RigFiles(world, known_map, TASK / "places.yaml", {"objects": objects}, "home"), seed=1)


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    return before_a_pallet(tmp_path_factory.mktemp("pallet"))


def walls_on_pallet(rig: Rig, grid: GridMap, seen_from: float) -> list[tuple[float, float]]:
    """Return the middles of the walls on the pallet, in [m] on the map."""
    objects = rig.model.of(Objects)
    walls = objects.walls_near(grid, Pose2(3.9, 1.8, 0.0), seen_from=seen_from)
    pallet = objects.objects.surfaces["pallet"]
    middles = [(float(wall.pose[0, 3]), float(wall.pose[1, 3])) for wall in walls]
    return [middle for middle in middles if pallet.margin(*middle) > 0.0]


def with_blocked(grid: GridMap, low: tuple[float, float], high: tuple[float, float]) -> GridMap:
    """Return a map in which a rectangle is an obstacle."""
    occupied = grid.occupied.copy()
    (row, column), (last_row, last_column) = grid.to_cell(np.array([low, high]))
    occupied[row:last_row, column:last_column] = True
    return grid._replace(occupied=occupied)


def test_screen_on_a_surface_below_the_lidar_is_a_wall(rig: Rig) -> None:
    (middle,) = walls_on_pallet(rig, rig.model.map, LIDAR_M)
    assert middle == pytest.approx((3.9, 1.36), abs=0.02)


@pytest.mark.parametrize("seen_from", [0.0, 0.1, 0.16])
def test_screen_on_a_surface_above_the_lidar_is_the_surface(rig: Rig, seen_from: float) -> None:
    """Such a lidar sees the surface's sides and legs; without a lidar nothing is known."""
    assert not walls_on_pallet(rig, rig.model.map, seen_from)


def test_low_surface_that_is_drawn_on_the_map_is_no_wall(rig: Rig) -> None:
    """Somebody drew it, so that the base keeps off it."""
    assert not walls_on_pallet(rig, with_blocked(rig.model.map, (3.75, 0.95), (4.25, 1.45)), LIDAR_M)


def test_edge_of_a_low_surface_on_the_map_is_no_wall(rig: Rig) -> None:
    edged = with_blocked(rig.model.map, (3.75, 1.42), (4.25, 1.45))
    assert walls_on_pallet(rig, edged, LIDAR_M) == walls_on_pallet(rig, rig.model.map, LIDAR_M)


def test_known_object_on_a_low_surface_is_no_wall(rig: Rig) -> None:
    on_it = with_blocked(rig.model.map, (3.87, 1.16), (3.93, 1.24))
    assert walls_on_pallet(rig, on_it, LIDAR_M) == walls_on_pallet(rig, rig.model.map, LIDAR_M)


@pytest.mark.slow
@pytest.mark.parametrize("screen_y", [1.36, 1.05])
def test_arm_keeps_clear_of_a_screen_on_a_pallet(tmp_path: Path, screen_y: float) -> None:
    """The arm went through it, before the parcel or behind it."""
    with before_a_pallet(tmp_path, screen_y) as rig:
        for primitive in (MoveTo(place="pallet"), LookFor(object="parcel_1"), Pick(object="parcel_1")):
            outcome = rig.do(primitive)
            assert isinstance(outcome, Success), outcome
        assert not [item for item in scene_of(rig).contacts if "screen" in (item.body, item.other)]
