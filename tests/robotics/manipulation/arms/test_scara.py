import math
from collections.abc import Callable

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.arms.resolved_rate import ResolvedRate, line_postures, way_to
from handcart.robotics.manipulation.arms.scara import Scara, base_to_world, world_to_base

ARM = Scara()
DT = 0.02
STOWED, MIDDLE = np.array(ARM.stowed), np.array(ARM.middle)
Jacobian = Callable[[np.ndarray], np.ndarray]


def printed(q: np.ndarray) -> np.ndarray:
    """Eq. 5 as printed in the paper."""
    one, both = q[0], q[0] + q[1]
    return np.array(
        [
            [-ARM.upper * math.cos(one) - ARM.fore * math.sin(both), -ARM.fore * math.sin(both)],
            [ARM.fore * math.cos(one) + ARM.fore * math.cos(both), ARM.fore * math.cos(both)],
        ]
    )


def joints_for(point: np.ndarray) -> np.ndarray | None:
    """Angles and slide (3,) that hold the tip at a point of the base frame; None if it can't be reached."""
    x, y, z, yaw = ARM.mount
    angles = ARM.inverse(Pose2(x, y, yaw).inverse().apply(point[None, :2]).reshape(2))
    lowered = z - float(point[2])
    inside = ARM.slide[0] <= lowered <= ARM.slide[1]
    return None if angles is None or not inside else np.array([*angles, lowered])


def differences(q: np.ndarray) -> np.ndarray:
    step = 1e-5 * np.eye(2)
    columns = [
        (8 * (ARM.tip(q + s) - ARM.tip(q - s)) - (ARM.tip(q + 2 * s) - ARM.tip(q - 2 * s))) / 12e-5
        for s in step
    ]
    return np.column_stack(columns)


def targets(count: int, seed: int = 0) -> np.ndarray:
    """(n, 2) everywhere in reach, also at the edges."""
    rng = np.random.default_rng(seed)
    low, high = zip(ARM.theta1_working, ARM.theta2, strict=True)
    return np.array([ARM.tip(q) for q in rng.uniform(low, high, (count, 2))])


def lead(q: np.ndarray, target: np.ndarray, jacobian: Jacobian | None = None) -> tuple[np.ndarray, float]:
    """Return the final joints, and the distance of the tip from its lines."""
    astray = 0.0
    way = way_to(ARM, q, target)
    assert way is not None
    for place in way:
        control = ResolvedRate(ARM, ARM.tip(q), place, jacobian=jacobian)
        for _ in range(1500):
            q = q + DT * control.command(q, DT)
            astray = max(astray, control.astray(q))
            if control.left(q) < 2e-4:
                break
        assert jacobian is not None or ARM.within(q)
    return q, astray


def worst_jacobian(jacobian: Jacobian) -> float:
    rng = np.random.default_rng(1)
    return max(
        float(np.abs(jacobian(q) - differences(q)).max()) for q in rng.uniform(-math.pi, math.pi, (500, 2))
    )


def test_the_jacobian_is_the_derivative_and_the_printed_one_is_not() -> None:
    assert worst_jacobian(ARM.jacobian) < 1e-8
    assert worst_jacobian(printed) > 0.3


@pytest.mark.slow
def test_every_target_in_reach_is_reached_on_a_straight_line() -> None:
    for target in targets(100):
        q, astray = lead(MIDDLE, target)
        assert np.hypot(*(ARM.tip(q) - target)) < 1e-3
        assert astray < 0.5e-3
        assert ARM.within(q, working=True)


@pytest.mark.slow
def test_the_printed_jacobian_fails_the_same() -> None:
    good = 0
    for target in targets(5):
        q, astray = lead(MIDDLE, target, printed)
        good += bool(np.hypot(*(ARM.tip(q) - target)) < 1e-3 and astray < 0.5e-3)
    assert good < 3


def test_inverse_returns_the_posture_and_rejects_beyond_limits() -> None:
    rng = np.random.default_rng(2)
    low, high = zip(ARM.theta1_working, ARM.theta2, strict=True)
    for q in rng.uniform(low, high, (200, 2)):
        assert ARM.inverse(ARM.tip(q)) == pytest.approx(q)
    assert ARM.inverse(np.array([1.2, 0.0])) is None
    assert ARM.inverse(np.array([0.05, 0.0])) is None
    assert ARM.inverse(ARM.tip(STOWED)) is None  # beyond 90 degrees nothing is laid
    assert way_to(ARM, MIDDLE, np.array([-0.5, 0.0])) is None
    assert line_postures(ARM, MIDDLE, np.array([-0.5, 0.0])) is None


def test_from_stowed_to_the_middle_state_keeps_the_limits() -> None:
    for share in np.linspace(0.0, 1.0, 50):
        assert ARM.within(STOWED + share * (MIDDLE - STOWED))


def test_tilt_is_in_the_kinematics() -> None:
    rng = np.random.default_rng(3)
    placed = 0
    for _ in range(100):
        x, y = rng.uniform(-5, 5, 2).tolist()
        pose = Pose2(x, y, rng.uniform(-3, 3))
        tilt = tuple(np.radians(rng.normal(0.0, 2.5, 2)).tolist())
        aside = rng.uniform((-0.2, -0.9), (0.2, -0.5))
        target = np.array([*pose.apply(aside[None])[0], 0.05])
        q = joints_for(world_to_base(pose, tilt, target))
        if q is None:
            continue
        placed += 1
        assert base_to_world(pose, tilt, ARM.base_tip(q)) == pytest.approx(target)
    assert placed > 40


def test_a_tilt_that_is_not_known_is_what_is_missed() -> None:
    pose, tilt = Pose2(0.0, 0.0, 0.0), (math.radians(2.5), 0.0)
    target = np.array([0.0, -0.75, 0.0])
    blind = joints_for(world_to_base(pose, (0.0, 0.0), target))
    assert blind is not None
    low, high = (
        base_to_world(pose, tilt, ARM.base_tip(np.array([*blind[:2], slide]))) for slide in (0.6, 0.2)
    )
    assert np.hypot(*(low - high)[:2]) == pytest.approx(0.4 * math.sin(tilt[0]), rel=1e-6)


def test_a_slide_too_short_is_out_of_reach() -> None:
    assert joints_for(np.array([0.0, -0.8, -0.1])) is None
    assert joints_for(np.array([0.0, -0.8, 0.7])) is None
