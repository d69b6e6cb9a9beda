"""PLACE's look at a spot where something almost as grey as the surface lies, or nothing."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from benchmarks.objects.handing import rig_holding, scene_of
from handcart.backends.simulation.world.thing import Rest
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.objects import place_object
from handcart.primitives.objects.knowledge.objects import Objects, ObjectSighting
from handcart.primitives.objects.looking import tag_readings
from handcart.primitives.objects.looking.tag_readings import NotUpright, ReadTag
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2
from tests.primitives.changed_scene import do_when

from .fetching import TASK, changed
from .head_robot import head_robot

TABLE_GREY = 110
SEEN_COVARIANCE = ((1e-6, 0.0, 0.0), (0.0, 1e-6, 0.0), (0.0, 0.0, 1e-6))


def before_table_b(folder: Path, objects: Path = TASK / "objects.yaml", **thing: Any) -> Rig:
    """Return a robot with a parcel in its hand before table B, with a flat thing on the spot `right`."""
    pose = ("x_m: 1.0, y_m: 1.0, heading_deg: 0.0", "x_m: 4.3, y_m: 2.0, heading_deg: 0.0")
    world = changed(folder, "world.yaml", pose)
    if thing:
        data = yaml.safe_load(world.read_text(encoding="utf-8"))
        lies = {"name": "card", "x_m": 5.05, "y_m": 1.8, "height_m": 0.6, "size_mm": [60, 40, 2], **thing}
        data["objects"].append(lies)
        world.write_text(yaml.safe_dump(data), encoding="utf-8")
    return rig_holding(world, seed=3, places=changed(folder, "places.yaml", pose), objects=objects)


@pytest.mark.slow
@pytest.mark.parametrize("contrast", [10, 20, 30, -10])
def test_thing_almost_as_grey_as_the_table_is_seen(tmp_path: Path, contrast: int) -> None:
    with before_table_b(tmp_path, grey=TABLE_GREY + contrast) as rig:
        outcome = rig.do(PlaceObject(surface="table_b", spot="right"))
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause.name == "occupied"
        parcel = scene_of(rig).thing_named("object parcel_1")
        assert parcel is not None and parcel.rest is Rest.HAND


@pytest.mark.slow
def test_edge_of_the_table_beside_a_spot_is_no_thing(tmp_path: Path) -> None:
    """The margin around the foot reaches beyond the table, whose front is almost as grey as its top."""
    spot = "right: {x_m: 5.05, y_m: 1.8}"
    objects = changed(tmp_path, "objects.yaml", (spot, "right: {x_m: 4.955, y_m: 1.8, heading_deg: 45}"))
    with before_table_b(tmp_path, objects) as rig:
        outcome = rig.do(PlaceObject(surface="table_b", spot="right"))
        assert isinstance(outcome, Success), outcome


def behind_a_screen(folder: Path) -> Rig:
    """Return a robot that holds a parcel before table B; a mapped screen is between it and a spot."""
    (x0, x1), y, thick = (4.7, 4.88), 1.93, 0.1
    pose = ("x_m: 1.0, y_m: 1.0, heading_deg: 0.0", "x_m: 4.3, y_m: 2.0, heading_deg: 0.0")
    picture = cv2.imread(str(TASK / "map.png"), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    rows, columns = np.indices(picture.shape)
    at_x, at_y = 0.02 * columns - 0.25, 0.02 * (len(picture) - 1 - rows) - 0.25
    picture[(x0 < at_x) & (at_x < x1) & (abs(at_y - y) < thick / 2)] = 0
    cv2.imwrite(str(folder / "map.png"), picture)
    world = changed(folder, "world.yaml", pose)
    data = yaml.safe_load(world.read_text(encoding="utf-8"))
    data["walls"].append({"from_m": [x0, y], "to_m": [x1, y], "thickness_m": thick})
    world.write_text(yaml.safe_dump(data), encoding="utf-8")
    places, known_map = changed(folder, "places.yaml", pose), changed(folder, "map.yaml")
    return rig_holding(world, seed=3, places=places, known_map=known_map)


@pytest.mark.slow
def test_spot_behind_a_mapped_screen_is_out_of_reach(tmp_path: Path) -> None:
    """The arm reached through the screen where no other posture puts the object down there."""
    with behind_a_screen(tmp_path) as rig:
        outcome = rig.do(PlaceObject(surface="table_b", spot="right"))
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause.name == "out_of_reach"
        assert not scene_of(rig).contacts


def knowing_the_other(folder: Path) -> Rig:
    """Return a robot before table B that saw the other parcel there, beside the spot `right`."""
    stands = ("name: parcel_2, x_m: 2.3, y_m: 3.7", "name: parcel_2, x_m: 5.05, y_m: 1.65")
    pose = ("x_m: 1.0, y_m: 1.0, heading_deg: 0.0", "x_m: 4.3, y_m: 2.0, heading_deg: 0.0")
    world, places = changed(folder, "world.yaml", pose, stands), changed(folder, "places.yaml", pose)
    rig = rig_holding(world, str(head_robot(folder / "head")), seed=3, places=places)
    seen = ObjectSighting("parcel_2", "table_b", Pose2(5.05, 1.65, math.radians(70.0)), SEEN_COVARIANCE)
    rig.model.of(Objects).sightings = (seen,)
    return rig


@pytest.mark.slow
@pytest.mark.parametrize("by_m", [0.0, 0.04])
def test_object_that_seems_moved_is_looked_at_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, by_m: float
) -> None:
    """From a camera on a head, a small tag may be read as one that is tilted."""
    rig, honest, first = knowing_the_other(tmp_path), tag_readings.locate, list[Any]()
    parcel_2 = scene_of(rig).thing_named("object parcel_2")
    assert parcel_2 is not None

    def read(reads: list[ReadTag], *of: Any) -> Any:
        first.append(reads[0].view)
        return NotUpright("it is tilted") if reads[0].view is first[0] else honest(reads, *of)

    monkeypatch.setattr(place_object, "locate", read)

    def move(scene: Any) -> None:
        parcel_2.pose[1, 3] -= by_m

    outcome = do_when(rig, PlaceObject(surface="table_b", spot="right"), lambda it: it.held is None, move)
    assert len(first) == 2
    if by_m:
        assert isinstance(outcome, GiveUp), outcome
        assert (outcome.cause.name, outcome.reason) == ("misplaced", "parcel_2 was moved")
    else:
        assert isinstance(outcome, Success), outcome
