"""TRACK alone, and what DIVIDE and it know of the work on a seam."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.primitives.seam.divide import Divide
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.seam_work import SeamPart, SeamWork
from handcart.primitives.seam.track import Track, _check_known
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.placement.placement_division import PathSegment
from handcart.robotics.manipulation.placement.placements import Placements

HERE = Pose2(2.0257, 3.0387, math.radians(-25.62))
"""Whence the seam's begin can be tracked."""
LAST = 12


@pytest.fixture
def make_stage(rig_at: Callable[..., Rig]) -> Callable[..., Rig]:
    """Return a maker of rigs at the place for the first points of the shipped seam."""

    def made(old: str = "", new: str = "") -> Rig:
        rig = rig_at(HERE, LAST, old=old, new=new)
        rig.model.of(Seam).seam_work = SeamWork(0, SeamPart("place_1", HERE, 0, LAST, 0.1), (), 1)
        return rig

    return made


def test_a_part_is_tracked_and_counts_as_done(make_stage: Callable[..., Rig]) -> None:
    rig = make_stage()
    ended = rig.do(Track())
    assert isinstance(ended, Success), ended
    assert float(str(ended.evidence["off_mm"])) < 1.5
    assert rig.model.of(Seam).seam_work.tracked == LAST
    assert rig.model.of(Seam).seam_work.rest == ()


UNSURE = {" sigma_mm": 12.0, "heading_sigma_mrad": 20.0}


@pytest.mark.parametrize("key", list(UNSURE))
def test_a_base_whose_place_or_heading_is_unsure_tracks_nothing(
    make_stage: Callable[..., Rig], key: str
) -> None:
    """A heading is as bad as a place: the tool is a metre away."""
    failed = make_stage(f"{key}: 0.3", f"{key}: {UNSURE[key]}").do(Track())
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the pose of the base isn't known exactly enough"


def test_what_the_tool_touches_ends_it(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, track = make_stage(), Track()
    pressed = np.array([0.0, 12.0, 12.0])
    monkeypatch.setattr(
        type(rig.robot.arm), "hand_force", lambda _: pressed if track.tracking is not None else 0 * pressed
    )
    failed = rig.do(track)
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the tool touches something"


def test_a_tool_that_leaves_the_seam_ends_it(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The joints' readings show it: a gear that slips by a quarter of a degree, at more than a metre."""
    rig, track = make_stage(), Track()
    arm = type(rig.robot.arm)
    plain = arm.joints

    def slipped(self: Any) -> Any:
        off = np.zeros(self.command().size)
        off[0] = math.radians(0.25) if track.tracking is not None else 0.0
        return plain(self) + off

    monkeypatch.setattr(arm, "joints", slipped)
    failed = rig.do(track)
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the tool leaves the seam"


def test_parts_follow_each_other_and_the_last_one_leaves_nothing() -> None:
    parts = tuple(SeamPart(f"place_{n}", HERE, 10 * n, 10 * n + 10, 0.5) for n in range(3))
    work = SeamWork(0, parts[0], parts[1:], 3)
    for number in range(1, 3):
        work = work.done()
        assert (work.tracked, work.next, work.rest) == (10 * number, parts[number], parts[number:])
    work = work.done()
    assert work.next is not None
    assert (work.tracked, work.next.place, work.next.empty, work.rest) == (30, "place_2", True, ())


def test_a_rest_is_divided_by_the_numbers_of_the_whole_seam(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = make_stage()
    rig.model.of(Seam).seam_work = SeamWork(5, None, (), 2)
    asked = []

    def place(rest: Any, *_: Any) -> Placements:
        asked.append(len(rest.points))
        bases = np.array([HERE, HERE])
        return Placements(bases, (PathSegment(0, 0, 3), PathSegment(1, 3, LAST - 5)), (0.1, 0.2))

    monkeypatch.setattr("handcart.primitives.seam.divide.placer_of", lambda _: SimpleNamespace(place=place))
    assert isinstance(rig.do(Divide(placements=2)), Success)
    work = rig.model.of(Seam).seam_work
    assert asked == [LAST - 5 + 1]
    assert [(item.place, item.first, item.last) for item in work.rest] == [
        ("place_3", 5, 8),
        ("place_4", 8, LAST),
    ]
    assert {"place_3", "place_4"} <= rig.model.places.keys()


def test_divide_keeps_off_what_was_sensed_beside_the_map(
    make_stage: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cells that beams may clear again block places to stand as the map does."""
    rig, asked = make_stage(), list[Any]()
    x, y = np.meshgrid(np.arange(-3.0, 3.0, 0.25), np.arange(-3.0, 3.0, 0.25))
    spots = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]) + np.array([*rig.robot.pose[:2], 0.0])

    def place(rest: Any, blocked: Any, *_: Any) -> Placements:
        asked.append(blocked(spots))
        return Placements(np.array([HERE]), (PathSegment(0, 0, len(rest.points) - 1),), (0.1,))

    monkeypatch.setattr("handcart.primitives.seam.divide.placer_of", lambda _: SimpleNamespace(place=place))
    rig.model.of(Seam).seam_work = SeamWork(0, None, (), 0)
    assert isinstance(rig.do(Divide(placements=1)), Success)
    rig.model.of(Seam).seam_work = SeamWork(0, None, (), 0)
    free = spots[~asked[0]]
    spot = free[np.argmax(np.hypot(*(free[:, :2] - rig.robot.pose[:2]).T))]
    rig.model.sensed_cells = np.array([[*spot[:2], 12.0, 0.0]])
    assert isinstance(rig.do(Divide(placements=1)), Success)
    near = np.hypot(*(spots[:, :2] - spot[:2]).T) < 0.2
    assert asked[1][near].all()
    assert not asked[0][near].all()


@pytest.mark.parametrize(
    ("sigmas", "known"),
    [((3e-4, 3e-4, 1e-4), True), ((1e-3, 3e-4, 1e-4), False), ((3e-4, 3e-4, 9e-4), False)],
)
def test_three_sigma_of_the_tool_are_within_its_tolerance(
    sigmas: tuple[float, float, float], known: bool
) -> None:
    robot: Any = SimpleNamespace(localization=SimpleNamespace(covariance=np.diag(sigmas) ** 2))
    if known:
        _check_known(robot)
        return
    with pytest.raises(Discrepancy, match="the pose of the base isn't known exactly enough"):
        _check_known(robot)
