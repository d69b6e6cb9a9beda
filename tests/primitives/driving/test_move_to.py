"""MOVE_TO and MODIFY at their public face, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from handcart.primitives.driving.local_replanning import LocalReplanning
from handcart.primitives.driving.modify import Modify
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import transform
from tests.primitives.conftest import Rig

BOX = "surprises:\n  - {{name: box, x_m: {x}, y_m: {y}, heading_deg: 20, size_m: [0.5, 0.4, 0.6]{more}}}\n"


@pytest.mark.slow
def test_it_docks_square_before_a_shelf(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(seed=3)
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    truth = Pose2(*map(float, rig.scene.base))
    assert abs(truth.y - 4.93) < 0.006  # the front was measured
    assert abs(truth.x - 6.5) < 0.04  # along it the map counts
    assert abs(truth.theta - math.pi / 2) < math.radians(0.4)


@pytest.mark.slow
def test_unmapped_box_is_a_fail_and_modify_leads_around_it(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=3.0, y=1.1, more=""))
    before = rig.scene.base
    failed = rig.run(MoveTo(place="shelf_1", wait_s=1.0, detour=False))
    assert isinstance(failed, Fail)
    assert "an obstacle is on the path to shelf_1" in failed.reason
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert rig.restored == [failed.reason]
    assert len(rig.model.obstacles) > 0

    assert isinstance(rig.run(Modify(place="shelf_1")), Success)
    assert rig.model.detour is not None
    gaps = rig.model.detour.points[:, None] - rig.model.obstacles[None]
    assert np.linalg.norm(gaps, axis=2).min() > rig.robot.spec.footprint_radius_m
    assert isinstance(rig.run(MoveTo(place="shelf_1")), Success)
    assert rig.model.detour is None


@pytest.mark.slow
def test_a_passer_by_is_waited_for(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=3.0, y=1.1, more=", leaves_s: 12"))
    assert isinstance(rig.run(MoveTo(place="shelf_1", wait_s=30.0)), Success)
    assert rig.robot.time > 12.0


def test_where_no_other_way_leads_modify_fails_for_good(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    rig.model.obstacles = np.column_stack([np.linspace(-0.1, 8.1, 200), np.full(200, 4.0)])
    failed = rig.run(Modify(place="shelf_1"))
    assert isinstance(failed, Fail)
    assert failed.permanent
    assert "shelf_1" in failed.reason
    assert isinstance(rig.run(Modify(place="home")), Success)


def test_an_unknown_place_is_a_fail_that_nothing_moved_for(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    failed = rig.run(MoveTo(place="cellar"))
    assert isinstance(failed, Fail)
    assert failed.permanent
    assert "unknown place 'cellar'" in failed.reason


def test_passers_by_are_waited_for_one_by_one() -> None:
    """Each of them may take `wait_s`; two in a row do not count as one that stays."""
    move, way = MoveTo(place="there", wait_s=5.0), np.array([[0.0, 0.0], [2.0, 0.0]])
    in_the_way = (0.5, np.array([1.0, 0.0]))
    known = SimpleNamespace(lost=None, heading_known=True)
    now: Any = SimpleNamespace(time=0.0, lidar=None, localization=known)
    stands: list[Any] = [None]
    monitor = SimpleNamespace(
        unexpected=lambda _: way[1:], obstacle=lambda *_: stands[0], kept=lambda points, _: points
    )
    move._monitor = cast(Any, monitor)
    move._ahead = way
    model: Any = SimpleNamespace(obstacles=np.empty((0, 2)), map=None)
    for now.time, stands[0] in ((0.0, in_the_way), (4.9, in_the_way), (5.0, None), (5.1, in_the_way)):
        move.watch(now, model)
    now.time = 10.0
    move.watch(now, model)
    now.time = 10.2
    with pytest.raises(Discrepancy, match=r"an obstacle is on the path to there, at \(1\.00, 0\.00\) m"):
        move.watch(now, model)
    assert len(model.obstacles) == 1


def test_with_the_arm_out_the_base_does_not_drive(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = make_rig()
    monkeypatch.setattr(rig.robot, "base_T", lambda _: transform((0.6, 0.1, 0.7)))
    outcome = rig.run(MoveTo(place="shelf_1"))
    assert isinstance(outcome, Fail)
    assert "the hand stands out beyond the robot's footprint" in outcome.reason
    assert rig.robot.time < 2.0


def test_a_wait_on_arrival_does_not_end_the_measuring_stop(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A passer-by is seen on the route's last centimetres; the base arrives, and measures for 3 s."""
    rig = make_rig()
    places = {"ahead": Place(x_m=1.0, y_m=2.0, heading_deg=90.0)}
    rig.model.places = {**rig.model.places, **places}
    stop, measured = places["ahead"].pose._replace(y=1.65), []

    def measuring() -> Generator[None, None, bool]:
        yield from rig.robot.wait(3.0)
        measured.append(rig.robot.pose.distance(stop))
        return True

    def since(_: LocalReplanning) -> float | None:
        return None if measured or rig.robot.pose.distance(stop) > 0.03 else rig.robot.time

    monkeypatch.setattr(rig.model, "measuring", lambda *_: None if measured else measuring())
    monkeypatch.setattr(LocalReplanning, "waits_since", property(since))
    outcome = rig.run(MoveTo(place="ahead", wait_s=1.0))
    assert isinstance(outcome, Success), outcome
    assert len(measured) == 1
    assert measured[0] < 0.03


@pytest.mark.slow
def test_who_comes_behind_a_waiting_base_is_not_in_its_way(make_rig: Callable[..., Rig]) -> None:
    """The base rolls on for 0.4 m after it began to wait: an obstacle behind it is then not ahead."""
    pallet = BOX.format(x=3.0, y=1.1, more=", leaves_s: 12")
    person = (
        "  - {name: person, x_m: 1.333, y_m: 1.077, heading_deg: 0, size_m: [0.1, 0.1, 1.7], appears_s: 8}\n"
    )
    rig = make_rig(f"{pallet}{person}\n")
    outcome = rig.run(MoveTo(place="shelf_1", wait_s=18.0))
    assert isinstance(outcome, Success), outcome
    assert rig.robot.time < 45.0


def test_what_stands_behind_while_restoring_is_on_the_way_back(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(BOX.format(x=1.5, y=1.1, more=", appears_s: 5"))
    outcome = rig.run(MoveTo(place="shelf_1", wait_s=2.0, detour=False), cancel=lambda: rig.robot.time > 5.0)
    assert isinstance(outcome, GiveUp)
    assert "restoring failed: an obstacle is on the way back, at (" in outcome.reason
