"""TRACK while the base drives along."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.world.scene import Scene
from handcart.evaluation.seam.seam_survey import distances
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.primitives.seam.divide import Divide
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.track import Track
from handcart.robotics.geometry.pose2 import Pose2

HERE = Pose2(2.012, 2.99, math.radians(0.4))
"""About where the way beside the seam begins."""
LAST = 150


@pytest.fixture
def make_rig(rig_at: Callable[..., Rig]) -> Callable[..., Rig]:
    """Before the first metre and a half of the shipped seam, divided; `world` is added to the world."""

    def made(world: str = "", old: str = "", new: str = "") -> Rig:
        rig = rig_at(HERE, LAST, world, old, new)
        assert isinstance(rig.do(Divide(placements=1, base="drives")), Success)
        return rig

    return made


def scene_of(rig: Rig) -> Scene:
    """The ground truth."""
    return rig.backend.scene  # type: ignore[attr-defined, no-any-return]


def base_of(rig: Rig) -> Pose2:
    """Return the true pose of the base."""
    return scene_of(rig).base


@pytest.mark.slow
def test_the_tool_stays_on_the_seam_while_the_base_drives(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Measured by the ground truth; `robot.pose` would share the localizer's error."""
    rig, track, tips = make_rig(), Track(), list[Any]()
    plain = Track.watch

    def look(self: Track, robot: Any, model: Any) -> None:
        if self.tracking is not None:
            tips.append(scene_of(rig).world_T("hand")[:3, 3].copy())
        plain(self, robot, model)

    monkeypatch.setattr(Track, "watch", look)
    before = base_of(rig)
    ended = rig.do(track)
    assert isinstance(ended, Success), ended
    seam = rig.model.of(Seam)
    assert seam.seam is not None
    assert seam.seam_work.tracked == LAST
    assert base_of(rig).distance(before) == pytest.approx(1.39, abs=0.05)
    assert len(tips) > 200
    assert distances(np.array(tips), seam.seam.points).max() < 0.003


@pytest.mark.slow
def test_the_robot_then_stands_at_the_ways_end(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    end = rig.model.of(Seam).seam_work.next
    assert end is not None
    assert end.end is not None
    assert isinstance(rig.do(Track()), Success)
    after = rig.model.of(Seam).seam_work.next
    assert after is not None
    assert (after.place, after.empty) == (end.end.place, True)
    assert base_of(rig).distance(rig.model.places[end.end.place].pose) < 0.045


def test_what_stands_in_the_way_is_a_fail_and_remembered(make_rig: Callable[..., Rig]) -> None:
    """The base is back, the arm folded; the next division keeps off it."""
    rig = make_rig("surprises:\n  - {name: crate, x_m: 3.6, y_m: 2.9, size_m: [0.4, 0.4, 0.6]}\n")
    before, home = base_of(rig), rig.robot.arm.command()
    failed = rig.do(Track())
    assert isinstance(failed, Fail), failed
    assert failed.reason.startswith("an obstacle is on the base's route along the seam")
    assert base_of(rig).distance(before) < 0.025
    assert np.abs(rig.robot.arm.command() - home).max() < 1e-6
    assert len(rig.model.obstacles)


@pytest.mark.slow
def test_tool_contact_while_driving_is_a_fail_and_base_returns(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = make_rig()
    before = base_of(rig)
    pressed = np.array([0.0, 12.0, 12.0])
    arm = type(rig.robot.arm)
    far: list[float] = []

    def felt(_: Any) -> Any:
        far.append(base_of(rig).distance(before))
        return pressed if 0.7 < far[-1] < 0.72 else 0 * pressed

    monkeypatch.setattr(arm, "hand_force", felt)
    failed = rig.do(Track())
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the tool touches something"
    assert max(far) > 0.7
    assert base_of(rig).distance(before) < 0.025


def test_a_base_that_stands_elsewhere_does_not_set_out(make_rig: Callable[..., Rig]) -> None:
    """The free space of its way was not checked from there."""
    rig = make_rig()
    work = rig.model.of(Seam).seam_work
    assert work.next is not None
    elsewhere = work.next.pose.compose(Pose2(0.0, -0.2, 0.0))
    rig.model.of(Seam).seam_work = work._replace(next=work.next._replace(pose=elsewhere))
    failed = rig.do(Track())
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the base isn't at place_1, where its route along the seam begins"


def test_a_base_that_is_known_by_its_wheels_alone_drives_no_seam(make_rig: Callable[..., Rig]) -> None:
    failed = make_rig("", "localizer: positioning", "localizer: odometry").do(Track())
    assert isinstance(failed, Fail), failed
    assert failed.reason == "the pose of the base isn't known exactly enough"
