"""Surfaces on the floor, and the base's place before walls and tall objects."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.knowledge.surface_places import standing_place
from handcart.robotics.navigation.maps.grid_map import GridMap

FREE = np.zeros((200, 200), dtype=np.bool_)
ROOM = GridMap(FREE, FREE, 0.03, 0.0, 0.0)
HOME = Place(x_m=1.0, y_m=1.0, heading_deg=0.0)


def file_with(surface: dict[str, Any], height_mm: float = 80.0) -> ObjectsFile:
    place = {"x_m": 3.0, "y_m": 3.0}
    kinds = {"tin": {"size_mm": [60, 60, height_mm]}}
    objects = {"tin_1": {"kind": "tin", "on": "here", **place}}
    data = {"format": "handcart-objects/1", "kinds": kinds, "surfaces": {"here": {**place, **surface}}}
    return ObjectsFile.model_validate({**data, "objects": objects})


def test_area_of_the_floor_is_solid_below() -> None:
    area = ObjectSurface(x_m=1.0, y_m=2.0, height_m=0.0, size_m=(0.6, 0.4))
    (body,) = area.boxes("mat")
    assert body.pose[2, 3] + body.size[2] / 2 == pytest.approx(0.0)
    assert set(area.contact_names("mat")) >= {"mat", "floor"}
    table = ObjectSurface(x_m=1.0, y_m=2.0, height_m=0.7, size_m=(0.6, 0.4))
    assert table.contact_names("table") == ("table",)


def test_base_keeps_clear_of_a_wall_outside_of_the_surface() -> None:
    walls = ["+x", "-x", "+y", "-y"]
    box = {"height_m": 0.5, "size_m": [0.3, 0.3], "walls": walls, "wall_m": 0.1}
    robot = load_robot("librarian")
    stand = standing_place(robot, ROOM, file_with(box), "here", [HOME])
    away = math.hypot(stand.x_m - 3.0, stand.y_m - 3.0)
    assert away - 0.15 - 0.02 - robot.footprint_radius_m >= 0.04


@pytest.mark.slow
def test_floor_area_has_a_place_from_which_a_tall_object_is_reached() -> None:
    area = {"height_m": 0.0, "size_m": [0.32, 0.32]}
    robot = load_robot("librarian")
    stand = standing_place(robot, ROOM, file_with(area, height_mm=240.0), "here", [HOME])
    assert math.hypot(stand.x_m - 3.0, stand.y_m - 3.0) - 0.16 > robot.footprint_radius_m
