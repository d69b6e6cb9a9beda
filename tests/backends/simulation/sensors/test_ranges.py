from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.world.solids import FloorPlan, Solid, of_furniture
from handcart.backends.simulation.world.world_file import Furniture, Surprise
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)


def box(
    x: float, y: float, heading: float = 0.0, size: tuple[float, float, float] = (1.0, 0.6, 1.0), **times: Any
) -> Solid:
    kind = Surprise if times else Furniture
    return of_furniture(kind(name="box", x_m=x, y_m=y, heading_deg=heading, size_m=size, **times))


def test_ranges_equal_those_of_one_box_at_a_time() -> None:
    rng = np.random.default_rng(1)
    places = [(x, y, h) for x, y, h in rng.uniform(-9, 9, (60, 3)) if math.hypot(x, y) > 1.0]
    plan = FloorPlan([box(x, y, 20 * h) for x, y, h in places], 0.25, 0.25)
    sensor = Pose2(0.1, -0.2, 0.7)
    expected = box_ranges([(x, y, math.radians(20 * h), 1.0, 0.6) for x, y, h in places], sensor, ANGLES)
    expected[expected > 8.0] = np.inf
    found = cast_rays(plan, sensor, ANGLES, 0.0, 8.0)
    assert np.array_equal(np.isinf(found), np.isinf(expected))
    seen = np.isfinite(found)
    assert found[seen] == pytest.approx(expected[seen], abs=1e-6)


def test_beams_may_come_in_any_order_and_from_any_turn() -> None:
    rng = np.random.default_rng(2)
    plan = FloorPlan([box(x, y, 20 * x) for x, y in rng.uniform(2, 6, (20, 2))], 0.25, 0.25)
    angles = rng.permutation(ANGLES)
    found = cast_rays(plan, Pose2(0, 0, 2.5), angles + 4 * np.pi, 0.0, 12.0)
    expected = cast_rays(plan, Pose2(0, 0, 2.5), ANGLES, 0.0, 12.0)[np.argsort(np.argsort(angles))]
    assert found == pytest.approx(expected)
    assert np.isfinite(found).sum() > 30


def test_a_wall_is_seen_as_far_as_the_lidar_reaches() -> None:
    plan = FloorPlan([box(2.0, 0.0, size=(0.2, 20.0, 1.0))], 0.25, 0.25)
    away = np.full(len(ANGLES), np.inf)
    ahead = np.cos(ANGLES) > 1e-6
    away[ahead] = 1.9 / np.cos(ANGLES[ahead])
    found = cast_rays(plan, Pose2(0, 0, 0), ANGLES, 0.0, 3.0)
    assert found == pytest.approx(np.where(away <= 3.0, away, np.inf))


def test_an_outline_that_contains_the_sensor_is_not_seen() -> None:
    around, wall = box(0.2, 0.0, size=(2.0, 2.0, 1.0)), box(5.0, 0.0, size=(0.2, 20.0, 1.0))
    found = cast_rays(FloorPlan([around, wall], 0.25, 0.25), Pose2(0, 0, 0), ANGLES, 0.0, 12.0)
    assert np.array_equal(found, cast_rays(FloorPlan([wall], 0.25, 0.25), Pose2(0, 0, 0), ANGLES, 0.0, 12.0))


def test_only_what_crosses_the_scan_plane_is_seen() -> None:
    low = box(2.0, 0.0, size=(1.0, 1.0, 0.2))
    plan = FloorPlan([low], 0.25, 0.25)
    assert np.isinf(cast_rays(plan, Pose2(0, 0, 0), ANGLES, 0.0, 12.0)).all()


@pytest.mark.parametrize(("time", "there"), [(0.9, False), (1.0, True), (2.9, True), (3.0, False)])
def test_a_surprise_is_seen_while_it_is_there(time: float, there: bool) -> None:
    plan = FloorPlan([box(2.0, 0.0, appears_s=1.0, leaves_s=3.0)], 0.25, 0.25)
    found = cast_rays(plan, Pose2(0, 0, 0), np.zeros(1), time, 12.0)
    assert found[0] == pytest.approx(1.5 if there else math.inf)
    assert (plan.clearance(0.0, 0.0, time)[0] < 2.0) is there


CORNERS = np.array([[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]])


@pytest.mark.parametrize("footprint", [Footprint(0.3), Footprint(0.4, CORNERS)], ids=["disc", "polygon"])
def test_no_footprint_touches_what_is_not_there_yet(footprint: Footprint) -> None:
    plan = FloorPlan([box(0.2, 0.0, appears_s=1.0, leaves_s=3.0)], 0.0, 1.0)
    assert plan.gap(Pose2(0, 0, 0), footprint, 0.5)[0] == math.inf
    assert plan.gap(Pose2(0, 0, 0), footprint, 1.5)[0] < 0.0


def test_clearance_is_the_distance_to_the_outline_and_negative_inside() -> None:
    plan = FloorPlan([box(2.0, 0.0), box(0.0, 5.0, heading=90.0)], 0.0, 1.0)
    away, name = plan.clearance(0.0, 0.0, 0.0)
    assert away == pytest.approx(1.5)
    assert name == "box"
    assert plan.clearance(2.0, 0.2, 0.0)[0] == pytest.approx(-0.1)
    assert plan.clearance(0.0, 4.0, 0.0)[0] == pytest.approx(0.5)
