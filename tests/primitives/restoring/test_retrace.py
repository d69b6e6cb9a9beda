"""Parts of the way back: a tolerance that widens with time, and the moment nearest to a pose."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.primitives.restoring.back_off import _way_in
from handcart.primitives.restoring.retrace import EXACT_REACH_S, WIDENING_S, _stretches, _travelled, _widened
from handcart.primitives.restoring.trace import GRIP_WEIGHT, NEAR_PERIODS, Moment, Trace, _apart
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance

TOLERANCE = SimpleNamespace(base_mm=40.0, base_deg=2.0)
ROBOT: Any = SimpleNamespace(spec=SimpleNamespace(tolerance=TOLERANCE))
HERE = Pose2(0.0, 0.0, 0.0)


def moment(pose: Pose2, rolled: Pose2 | None = None) -> Moment:
    return Moment(pose, np.empty(0), 0.0, rolled)


@pytest.mark.parametrize(
    ("share", "position", "heading_deg"),
    [(0.0, 0.004, 0.2), (0.5, 0.012, 0.6), (1.0, 0.02, 1.0), (3.0, 0.02, 1.0)],
)
def test_tolerance_widens_evenly_to_half_of_the_files(
    share: float, position: float, heading_deg: float
) -> None:
    exact = PoseTolerance(0.004, math.radians(0.2))
    found = _widened(ROBOT, exact, EXACT_REACH_S + share * WIDENING_S)
    assert found.position == pytest.approx(position)
    assert found.heading == pytest.approx(math.radians(heading_deg))


def test_tolerance_wider_than_half_of_the_files_stays() -> None:
    wide = PoseTolerance(0.03, math.radians(1.5))
    assert _widened(ROBOT, wide, EXACT_REACH_S + WIDENING_S) == pytest.approx(wide)


@pytest.mark.parametrize(
    ("end", "travelled"),
    [
        (Pose2(0.009, 0.0, 0.0), False),
        (Pose2(0.011, 0.0, 0.0), True),
        (Pose2(0.0, 0.0, 0.019), False),
        (Pose2(0.0, 0.0, 0.021), True),
    ],
)
def test_stretch_of_a_centimetre_or_a_degree_is_travelled(end: Pose2, travelled: bool) -> None:
    assert _travelled([moment(HERE), moment(end)]) is travelled


def test_nearest_moment_goes_by_the_pose_without_jumps() -> None:
    trace = Trace(ROBOT)
    trace.moments = [moment(HERE, Pose2(0.1 * number, 0.0, 0.0)) for number in range(5)]
    assert trace.nearest(Pose2(0.21, 0.0, 0.0)) == 2
    trace.moments = [moment(Pose2(0.1 * number, 0.0, 0.0)) for number in range(5)]
    assert trace.nearest(Pose2(0.29, 0.0, 0.0)) == 3


def test_nearest_moment_is_among_the_last_ones() -> None:
    trace = Trace(ROBOT)
    trace.moments = [moment(Pose2(float(number), 0.0, 0.0)) for number in range(NEAR_PERIODS + 3)]
    assert trace.nearest(HERE) == 3


def test_trace_is_split_where_the_base_starts_and_stops() -> None:
    ways = [0.0, 0.0, 0.0, 0.05, 0.1, 0.1, 0.1]
    moments = [moment(Pose2(way, 0.0, 0.0)) for way in ways]
    numbers = {id(moment_): number for number, moment_ in enumerate(moments)}
    found = [[numbers[id(item)] for item in stretch] for stretch in _stretches(moments)]
    assert found == [[0, 1, 2], [2, 3, 4], [4, 5, 6]]


def test_turn_on_the_spot_is_a_stretch_and_jitter_is_not() -> None:
    turns = [0.0, 9e-5, 0.0, 0.02, 0.04, 0.04]
    moments = [moment(Pose2(0.0, 0.0, turn)) for turn in turns]
    assert [len(stretch) for stretch in _stretches(moments)] == [3, 3, 2]


def test_single_moment_is_one_stretch() -> None:
    only = moment(HERE)
    (stretch,) = _stretches([only])
    assert stretch[0] is only
    assert len(stretch) == 1


def test_way_after_the_nearest_moment_is_cut_and_the_arm_kept() -> None:
    """The base is back at 0.21 m of its way of 0.4 m: what it drove after 0.2 m is not driven again."""
    here, rolled = Pose2(5.2, 0.0, 0.0), Pose2(0.21, 0.0, 0.0)
    robot: Any = SimpleNamespace(pose=here, localization=SimpleNamespace(odometry_pose=rolled))
    trace = Trace(robot)
    ways = 0.1 * np.arange(5)
    before = [Moment(Pose2(5.0 + way, 0.0, 0.0), np.array([way]), way, Pose2(way, 0.0, 0.0)) for way in ways]
    trace.moments = list(before)
    trace.cut_to(robot)
    assert trace.moments[:3] == before[:3]
    assert [(moment.pose, moment.odometry_pose) for moment in trace.moments[3:]] == [(here, rolled)] * 2
    assert [(moment.joints.tolist(), moment.grip) for moment in trace.moments] == [
        ([way], way) for way in ways
    ]


def joints_at(trace: Trace) -> list[list[float]]:
    return [moment.joints.round(6).tolist() for moment in trace.moments]


def test_trace_left_is_what_was_not_retraced_and_the_deviation() -> None:
    """Ten steps out; five back, then the motion back deviates by two, and ends."""
    robot: Any = SimpleNamespace(joint_speeds=np.array([2.0, 2.0]), period=0.05)
    way, back = Trace(robot), Trace(robot)
    way.moments = [Moment(HERE, np.array([0.1 * k, 0.0]), 0.0) for k in range(11)]
    back.moments = [Moment(HERE, np.array([0.1 * k, 0.0]), 0.0) for k in range(10, 4, -1)]
    back.moments += [Moment(HERE, np.array([0.5, 0.1 * k]), 0.0) for k in (1, 2)]
    left = way.left_after(back)
    assert left.is_rest
    ways = [[0.1 * k, 0.0] for k in range(6)]
    assert joints_at(left) == np.round([*ways, [0.5, 0.0], [0.5, 0.1], [0.5, 0.2]], 6).tolist()
    assert not way.is_rest


def test_trace_that_was_retraced_leaves_its_begin() -> None:
    robot: Any = SimpleNamespace(joint_speeds=np.array([2.0]), period=0.05)
    way, back = Trace(robot), Trace(robot)
    way.moments = [Moment(HERE, np.array([0.1 * k]), 0.0) for k in range(5)]
    back.moments = way.moments[::-1]
    assert joints_at(way.left_after(back)) == [[0.0], [0.0]]


def test_trace_that_is_left_has_no_step_beyond_the_joints_speed() -> None:
    """A stuck arm was commanded on by 0.35 rad, which takes four periods at 2 rad/s; fingers move last."""
    robot: Any = SimpleNamespace(joint_speeds=np.array([2.0]), period=0.05)
    way, back = Trace(robot), Trace(robot)
    way.moments = [Moment(HERE, np.array([0.0]), 0.04), Moment(HERE, np.array([0.35]), 0.02)]
    back.moments = [Moment(HERE, np.array([0.35]), 0.02)]
    left = way.left_after(back)
    assert [moment.joints[0] for moment in left.moments] == pytest.approx(
        [0.0, 0.0875, 0.175, 0.2625, 0.35, 0.35]
    )
    assert [moment.grip for moment in left.moments] == [0.04] * 4 + [0.02] * 2


def test_moments_are_apart_by_what_changed_between_them() -> None:
    one = Moment(HERE, np.array([1.0, -2.0]), 0.03, None)
    assert _apart(one, one) == 0.0
    moved = one._replace(joints=np.array([1.0, -2.2]))
    assert _apart(one, moved) == _apart(moved, one) > 0.0
    assert _apart(one, one._replace(grip=0.02)) == pytest.approx(GRIP_WEIGHT * 0.01)
    assert _apart(one, one._replace(pose=Pose2(0.3, 0.4, 0.0))) == pytest.approx(0.5)


def test_way_in_does_not_go_on_behind_a_change_of_direction() -> None:
    """It came forwards over 1 m before it drove 0.1 m backwards and the last 0.3 m forwards."""
    ways = [*np.arange(0.0, 1.0, 0.05), *np.arange(1.0, 0.9, -0.05), *np.arange(0.9, 1.201, 0.05)]
    trace = Trace(ROBOT)
    trace.moments = [moment(Pose2(way, 0.0, 0.0)) for way in ways]
    blocked: Any = SimpleNamespace(pose=Pose2(1.2, 0.0, 0.0), direction=0.0, forwards=True)
    distances, _ = _way_in(trace, blocked, 2.0)
    assert distances[-1] == pytest.approx(0.3)
    assert _way_in(trace, blocked, 0.22)[0][-1] == pytest.approx(0.2)


@pytest.mark.parametrize(("forwards", "reach_m"), [(True, 0.5), (False, 0.0)])
def test_way_in_ends_where_the_base_came_from_the_other_side(forwards: bool, reach_m: float) -> None:
    """It drove backwards to 1 m, then forwards to 1.5 m, where it was stopped."""
    ways = [*np.arange(1.3, 1.0, -0.05), *np.arange(1.0, 1.501, 0.05)]
    trace = Trace(ROBOT)
    trace.moments = [moment(Pose2(way, 0.0, 0.0), Pose2(way, 0.0, 0.0)) for way in ways]
    blocked: Any = SimpleNamespace(pose=Pose2(1.5, 0.0, 0.0), direction=0.0, forwards=forwards)
    distances, headings = _way_in(trace, blocked, 2.0)
    assert distances[-1] == pytest.approx(reach_m)
    assert headings == pytest.approx(np.zeros(len(distances)))
