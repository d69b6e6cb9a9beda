"""Tags printed on the sides of a box are seen where the file says."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.description.things.printed_tag import Face, PrintedTag
from handcart.backends.simulation.objects.carried_object import CarriedObject
from handcart.backends.simulation.objects.spec import CarriedObjectSpec
from handcart.backends.simulation.world.canvas import Canvas
from handcart.backends.simulation.world.painting import paint_thing
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.transform import transform
from handcart.robotics.manipulation.grasping.camera_poses import camera_poses
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.tag_reader import read_tags, tag_pose

CAMERA = CameraModel(np.array([[800.0, 0, 319.5], [0, 800.0, 239.5], [0, 0, 1]]), np.zeros(5), 640, 480)
SIZE_MM = (80.0, 120.0, 100.0)


@pytest.mark.parametrize("face", ["-x", "+x", "-y", "+y", "-z", "+z"])
def test_tag_on_a_side_is_read_where_it_is(face: Face) -> None:
    tag = PrintedTag(id=11, side_mm=40.0, face=face, x_mm=8.0, y_mm=-12.0, turn_deg=20.0)
    spec = CarriedObjectSpec(name="a", x_m=0, y_m=0, height_m=0, size_mm=SIZE_MM, tags=(tag,))
    box = CarriedObject(transform((0.2, -0.1, 0.5), (0.0, 0.0, 0.7)), Rest.TABLE, spec)
    world_T_tag = box.pose @ tag.on_box(box.size)
    towards = transform(rpy=(0.3, -0.2, 0.1))[:3, :3] @ world_T_tag[:3, 2]
    pose = next(iter(camera_poses(world_T_tag[:3, 3], towards, 0.35)))
    canvas = Canvas(CAMERA.K, (640, 480), pose, 150)
    paint_thing(box).paint(canvas)
    (read,) = read_tags(canvas.picture, family=tag.family)
    seen = pose @ tag_pose(read, CAMERA, tag.side)
    assert read.id == 11
    assert seen[:3, 3] == pytest.approx(world_T_tag[:3, 3], abs=1e-3)
    assert seen[:3, :3] == pytest.approx(world_T_tag[:3, :3], abs=0.05)


def test_covered_print_is_grey_until_it_is_drawn_on_another() -> None:
    tag = PrintedTag(id=11, side_mm=40.0, face="+x")
    spec = CarriedObjectSpec(name="a", x_m=0, y_m=0, height_m=0, size_mm=SIZE_MM, tags=(tag,), grey=120)
    box = CarriedObject(np.eye(4), Rest.TABLE, spec)
    drawn = box.faces()["+x"]
    box.cover_print()
    assert drawn.min() < 60 < 200 < drawn.max()
    assert list(box.faces()) == ["+x"]
    assert (box.faces()["+x"] == 120).all()
    assert np.array_equal(CarriedObject(np.eye(4), Rest.TABLE, spec).faces()["+x"], drawn)


@pytest.mark.slow
def test_person_sets_an_object_down_by_its_sigmas() -> None:
    from tests.primitives.objects.fetching import rig_with, scene_of

    places = np.array(
        [[thing.pose[:2, 3] for thing in scene_of(rig_with(seed=seed)).things()] for seed in range(6)]
    )
    off = places - np.array([[1.9, 3.65], [2.3, 3.7]])
    assert 0.015 < off[:, 0].std() < 0.08  # sigma 40 mm
    assert off[:, 1].std() < 0.005  # as exact as the robot's file says
