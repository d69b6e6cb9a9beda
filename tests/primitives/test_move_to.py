"""MOVE_TO and MODIFY at their public face, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from primitives.modify import Modify
from primitives.move_to import MoveTo
from primitives.outcome import Fail, Success
from robotics.geometry.pose2 import Pose2

BOX = "surprises:\n  - {{name: box, x_m: {x}, y_m: {y}, heading_deg: 20, size_m: [0.5, 0.4, 0.6]{more}}}\n"


def test_it_docks_square_before_a_shelf(make_rig: Callable[..., Any]) -> None:
    rig = make_rig(seed=3)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    truth = Pose2(*map(float, rig.scene.base))
    assert abs(truth.y - 4.93) < 0.006  # the front was measured
    assert abs(truth.x - 6.5) < 0.04  # along it the map counts
    assert abs(truth.theta - math.pi / 2) < math.radians(0.4)


@pytest.mark.slow
@pytest.mark.parametrize(("x", "y"), [(3.0, 1.1), (4.5, 1.2)])
def test_a_box_that_is_not_on_the_map_is_a_fail_and_modify_leads_around_it(
    make_rig: Callable[..., Any], x: float, y: float
) -> None:
    rig = make_rig(BOX.format(x=x, y=y, more=""))
    before = rig.scene.base
    failed = rig.run(MoveTo(place="shelf_1", wait_s=1.0))
    assert isinstance(failed, Fail)
    assert "an obstacle stands on the path to shelf_1" in failed.reason
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert rig.restored == [failed.reason]
    assert len(rig.model.obstacles) > 0

    assert isinstance(rig.run(Modify(place="shelf_1")), Success)
    gaps = rig.model.detour.points[:, None] - rig.model.obstacles[None]
    assert np.linalg.norm(gaps, axis=2).min() > rig.robot.spec.footprint_radius_m
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert rig.model.detour is None


def test_a_passer_by_is_waited_for(make_rig: Callable[..., Any]) -> None:
    rig = make_rig(BOX.format(x=3.0, y=1.1, more=", leaves_s: 12"))
    assert isinstance(rig.run(MoveTo(place="shelf_1", wait_s=30.0)), Success)
    assert rig.robot.time > 12.0


def test_where_no_other_way_leads_modify_fails_for_good(make_rig: Callable[..., Any]) -> None:
    rig = make_rig()
    rig.model.obstacles = np.column_stack([np.linspace(-0.1, 8.1, 200), np.full(200, 4.0)])
    failed = rig.run(Modify(place="shelf_1"))
    assert isinstance(failed, Fail)
    assert failed.permanent
    assert "shelf_1" in failed.reason
    assert isinstance(rig.run(Modify(place="home")), Success)


def test_an_unknown_place_is_a_fail_that_nothing_moved_for(make_rig: Callable[..., Any]) -> None:
    rig = make_rig()
    failed = rig.run(MoveTo(place="cellar"))
    assert isinstance(failed, Fail)
    assert failed.permanent
    assert "no place 'cellar'" in failed.reason
