"""Ground behind a lidar of half a turn over which the base may drive back, and for how long."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.plain_values import attributes
from handcart.backends.robot.localization.lidar import Lidar
from handcart.backends.robot.unseen_ground import UnseenGround
from handcart.robotics.geometry.pose2 import Pose2

RADIUS = 0.34
BEAMS = 181


class Ahead(RangeSensor):
    """A lidar that sees the half ahead of it, where nothing is."""

    def scan(self) -> Scan:
        angles = np.radians(np.linspace(-90.0, 90.0, BEAMS))
        return Scan(angles, np.full(BEAMS, np.inf), Pose2(0.0, 0.0, 0.0))


class TurnedAside(RangeSensor):
    """A lidar on a corner, turned to the left, that sees more on its left than on its right."""

    def scan(self) -> Scan:
        angles = np.radians(np.linspace(-30.0, 120.0, BEAMS))
        return Scan(angles, np.full(BEAMS, np.inf), Pose2(0.2, 0.1, math.radians(40.0)))


class Driven:
    """A base that drives along a line of its own frame, and the ground that it knows."""

    def __init__(self, heading: float = 0.7) -> None:
        spec = RangeSpec(beams=BEAMS, reach_m=8.0, sigma_mm=10.0, start_deg=-90.0, end_deg=90.0)
        lidar = Lidar(Ahead(), load_robot("cart").model_copy(update={"range_sensor": spec}))
        self.time, self.here = 0.0, Pose2(5.0, -3.0, heading)
        self.ground = UnseenGround(lidar, RADIUS, lambda: self.here, lambda: self.time)

    def drive(self, way: float, step: float = 0.01) -> None:
        for _ in range(round(way / step)):
            assert self.ground.held(Pose2(0.0, 0.0, 0.0), 0.0, step) is None
            self.time += 0.05
            self.here = self.here.compose(Pose2(step, 0.0, 0.0))
        assert self.ground.held(Pose2(0.0, 0.0, 0.0), 0.0, step) is None

    def is_free_behind(self, length: float) -> bool:
        return self.ground.held(Pose2(0.0, 0.0, 0.0), 0.0, -length) is None


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5, -1.6])
def test_a_base_drives_back_the_way_it_came_and_no_further(heading: float) -> None:
    base = Driven(heading)
    assert not base.is_free_behind(0.2)
    base.drive(1.0)
    assert base.is_free_behind(0.5)
    assert base.is_free_behind(0.99)
    assert not base.is_free_behind(1.3)


def test_what_holds_it_is_where_the_unseen_ground_begins() -> None:
    base = Driven()
    held = base.ground.held(Pose2(10.0, 20.0, 0.5 * math.pi), 0.0, -0.3)
    assert held is not None
    assert held.shown_by == "unseen"
    assert (held.x, held.y) == pytest.approx((10.0, 20.0 - 0.3 - RADIUS), abs=0.02)
    assert held[3] == pytest.approx(0.3 + RADIUS, abs=0.02)
    assert held[4] == RADIUS


def test_ground_is_remembered_each_two_centimetres() -> None:
    """Each spot with the time when the base was there last."""
    base = Driven(0.0)
    base.drive(0.098, step=0.007)
    spots = np.array(attributes(base.ground, base.ground.STATE)["_driven"])
    assert spots[:, 0] == pytest.approx([5.0, 5.021, 5.042, 5.063, 5.084])
    assert spots[:, 1] == pytest.approx(np.full(5, -3.0))
    assert spots[:, 2] == pytest.approx([0.1, 0.25, 0.4, 0.55, 0.7])


@pytest.mark.parametrize(("time", "way"), [(60.0, 0.55), (62.0, 0.15), (64.0, 0.0)])
def test_a_new_action_forgets_ground_of_more_than_a_minute_ago(time: float, way: float) -> None:
    """It drove 0.6 m in the first three seconds; a hand's breadth about driven ground counts as such."""
    base = Driven()
    base.drive(0.6)
    base.time = time
    assert base.is_free_behind(0.55)  # in this action it counts, however long ago
    base.ground.starts_here()
    assert not base.is_free_behind(way + 0.16)
    if way:
        assert base.is_free_behind(way)


@pytest.mark.parametrize(
    ("given", "partial"),
    [({}, False), ({"masked_deg": ((0.0, 10.0),)}, True), ({"start_deg": -90.0, "end_deg": 90.0}, True)],
)
def test_ground_is_always_unseen_in_a_mask_or_behind(given: dict[str, object], partial: bool) -> None:
    spec = RangeSpec.model_validate({"beams": BEAMS, "reach_m": 8.0, "sigma_mm": 10.0, **given})
    lidar = Lidar(Ahead(), load_robot("cart").model_copy(update={"range_sensor": spec}))
    ground = UnseenGround(lidar, RADIUS, lambda: Pose2(0.0, 0.0, 0.0), lambda: 0.0)
    assert ground.is_partial == partial


def test_field_of_view_of_a_turned_lidar_is_told_in_the_base_frame() -> None:
    spec = RangeSpec(beams=BEAMS, reach_m=8.0, sigma_mm=10.0, start_deg=-30.0, end_deg=120.0)
    lidar = Lidar(TurnedAside(), load_robot("cart").model_copy(update={"range_sensor": spec}))
    view = UnseenGround(lidar, RADIUS, lambda: Pose2(0.0, 0.0, 0.0), lambda: 0.0).view
    assert view == pytest.approx((0.2, 0.1, math.radians(10.0), math.radians(150.0)))
