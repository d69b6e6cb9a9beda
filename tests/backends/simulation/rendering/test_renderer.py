from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import camera_model
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.rendering.renderer import Renderer
from handcart.backends.simulation.simulated_backend import build_scene
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.landmarks.tag_reader import read_tags

OPTICAL = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])


def scene(tag: str = "readable", gap: float = 31.0) -> Scene:
    book = {"call": "512.7 NAG", "thickness_mm": 40.0, "height_mm": 200.0, "depth_mm": 150.0, "grey": 140}
    row = [book | {"accession": 1}, {"gap_mm": gap}, book | {"accession": 2}]
    shelf = {"name": "s", "x_m": 2.0, "y_m": 0.0, "width_m": 0.4, "books": row}
    world = {
        "start": {"x_m": 0.0, "y_m": 0.0},
        "shelves": [shelf],
        "tray": book | {"accession": 3, "tag": tag},
    }
    file = world_model().model_validate({"format": "handcart-world/1"} | world)
    return build_scene(load_robot("librarian"), file, seed=0)


def picture(world: Scene, pose: Transform, seed: int = 0, period: int = 1) -> ByteArray:
    robot = load_robot("librarian")
    assert robot.camera is not None
    return Renderer(camera_model(robot.camera), robot.errors, seed).render(world, pose, period)


def before_shelf(world: Scene, y: float = 0.14, x: float = -0.3, z: float = 0.1) -> Transform:
    pose: Transform = world.of(BookProps).shelves["s"].pose @ transform((x, y, z)) @ OPTICAL
    return pose


def test_a_gap_is_darker_than_any_spine_and_stands_where_it_is() -> None:
    world = scene()
    image = picture(world, before_shelf(world)).astype(float)
    # The gap lies from y = 0.16 to 0.129, the camera before 0.14: 2.67 px a mm.
    columns = image[150:250].mean(axis=0)
    assert columns[280:335].max() < 40
    assert columns[200:250].min() > 60


@pytest.mark.parametrize(("tag", "read"), [("readable", [3]), ("smeared", []), ("none", [])])
def test_tray_book_tag_is_read_unless_smeared_or_missing(tag: str, read: list[int]) -> None:
    world = scene(tag)
    pose = world.of(BookProps).book_pose(3) @ transform((-0.25, 0.0, 0.17)) @ OPTICAL
    near = read_tags(picture(world, pose))
    assert [found.id for found in near if found.id == 3] == read


def test_the_picture_depends_on_seed_and_period_alone() -> None:
    world = scene()
    pose = before_shelf(world)
    first = picture(world, pose)
    assert np.array_equal(first, picture(world, pose))
    assert not np.array_equal(first, picture(world, pose, period=2))
    assert not np.array_equal(first, picture(world, pose, seed=1))


def test_from_behind_a_shelf_no_spine_is_seen() -> None:
    world = scene()
    behind = world.of(BookProps).shelves["s"].pose @ transform((1.0, 0.0, 0.1), (0.0, 0.0, np.pi)) @ OPTICAL
    assert read_tags(picture(world, behind)) == []


WALL = {"from_m": [0.5, -2.0], "to_m": [0.5, 2.0]}
PILLAR = {"name": "pillar", "x_m": 0.5, "y_m": 0.0, "size_m": [0.1, 0.3, 2.2]}
LOW_PILLAR = PILLAR | {"size_m": [0.1, 0.3, 1.5]}
FAR_BENCH = {"name": "wall bench", "x_m": 2.0, "y_m": 0.0, "size_m": [0.2, 1.2, 1.5]}
FAR_CUPBOARD = FAR_BENCH | {"name": "wall cupboard", "size_m": [0.2, 1.2, 2.2]}
TABLE = {"name": "t", "x_m": 1.0, "y_m": 0.0, "size_m": [0.6, 0.6, 1.2], "foot_m": [0.1, 0.1]}


def room(height: float = 1.2, **sections: Any) -> Scene:
    tag = {"id": 3, "face": "-x", "side_mm": 100}
    box = {"name": "box", "size_mm": [200.0, 200.0, 200.0], "x_m": 1.0, "y_m": 0.0}
    start = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}}
    objects = [box | {"height_m": height, "tags": [tag]}]
    file = world_model().model_validate(start | sections | {"objects": objects})
    return build_scene(load_robot("librarian"), file, seed=0)


def seen_at(world: Scene, z: float) -> ByteArray:
    return picture(world, transform((0.0, 0.0, z)) @ OPTICAL)


@pytest.mark.parametrize(
    ("sections", "z", "read"),
    [
        ({}, 1.3, [3]),
        ({"walls": [WALL]}, 1.3, []),
        ({"furniture": [PILLAR]}, 1.3, []),
        ({"furniture": [LOW_PILLAR, FAR_CUPBOARD]}, 1.3, []),
        ({"furniture": [FAR_BENCH]}, 1.3, [3]),
        ({"tables": [TABLE]}, 1.3, [3]),
        ({"tables": [TABLE]}, 1.5, [3]),
    ],
)
def test_a_tag_is_read_only_if_nothing_stands_before_it(
    sections: dict[str, Any], z: float, read: list[int]
) -> None:
    found = read_tags(seen_at(room(**sections), z), family="apriltag_36h11")
    assert [tag.id for tag in found] == read


def test_a_thing_on_the_floor_is_hidden_by_the_table_above_it() -> None:
    world = room(height=0.0, tables=[TABLE])
    above = transform((1.0, 0.0, 1.7), (0.0, np.pi / 2, 0.0)) @ OPTICAL
    bare = room(height=3.0, tables=[TABLE])
    assert np.array_equal(picture(world, above), picture(bare, above))


@pytest.mark.parametrize("near", [PILLAR, LOW_PILLAR])
@pytest.mark.parametrize("far", [FAR_BENCH, FAR_CUPBOARD])
def test_near_furniture_hides_farther_furniture_of_any_height(near: object, far: object) -> None:
    both = {"furniture": [near, far]}
    alone = {"furniture": [near]}
    columns = slice(200, 440)
    assert np.array_equal(
        seen_at(room(height=3.0, **both), 1.0)[300:, columns],
        seen_at(room(height=3.0, **alone), 1.0)[300:, columns],
    )
