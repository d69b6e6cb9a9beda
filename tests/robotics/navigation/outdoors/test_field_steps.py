"""When a filter outdoors makes a step, and what it is given: from one that only notes it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter

START = Pose2(1.0, 2.0, 0.5)
GRAVITY = np.array([0.0, 0.0, 9.81])


class Noted(FieldLocalizer):
    """Goes where the odometry goes; nothing corrects it."""

    REST_PERIOD = 1.0

    def __init__(self) -> None:
        super().__init__(START)
        self.steps: list[Advance] = []
        self.seen: list[object] = []
        self.here, self.origin = START, START

    @property
    def covariance(self) -> np.ndarray:
        return np.eye(3)

    def _set_origin(self) -> None:
        self.origin = self.here

    def _relative_pose(self) -> Belief:
        return Belief(np.array(self.here.relative_to(self.origin)), np.eye(3))

    def _estimate(self) -> Pose2:
        return self.here

    def _advance(self, advance: Advance) -> None:
        self.steps.append(advance)
        ahead = Pose2(advance.forward * math.cos(0.5 * advance.turn), 0.0, advance.turn)
        self.here = self.here.compose(ahead)

    def _fix(self, position: np.ndarray, sigma: float | None) -> bool:
        self.seen.append((len(self.steps), position.tolist(), sigma))
        return True

    def _ranges(self, distances: np.ndarray) -> None:
        self.seen.append((len(self.steps), distances.tolist()))

    def drive(self, periods: int, way: float = 0.01) -> None:
        for _ in range(periods):
            self.predict(np.zeros(3), GRAVITY, np.array([way, way]), 0.025)


class Radioed(Noted):
    TAKES_RANGES = True


def test_a_filter_steps_each_tenth_of_a_second() -> None:
    found = Noted()
    found.drive(3)
    assert found.steps == []
    assert found.pose == pytest.approx(START.compose(Pose2(0.03, 0.0, 0.0)))
    found.drive(5)
    assert len(found.steps) == 2
    for step in found.steps:
        assert (step.forward, step.time, step.rest) == pytest.approx((0.04, 0.1, 0.0))
    assert found.pose == pytest.approx(START.compose(Pose2(0.08, 0.0, 0.0)))


def test_at_rest_a_filter_steps_as_seldom_as_it_says() -> None:
    found = Noted()
    found.drive(20, 0.0)
    before = len(found.steps)
    found.drive(80, 0.0)
    assert found.odometry.at_rest
    times = [step.time for step in found.steps[before:]]
    assert times == pytest.approx([1.0, 1.0], abs=0.101)


def test_what_is_measured_between_steps_is_of_that_moment() -> None:
    found = Radioed()
    found.drive(2)
    assert found.fix(np.array([3.0, 4.0]), 0.5)
    found.drive(1)
    found.ranges(np.array([5.0]))
    found.ranges(np.array([6.0]))
    assert found.seen == [(1, [3.0, 4.0], 0.5), (2, [5.0]), (2, [6.0])]
    assert [step.forward for step in found.steps] == pytest.approx([0.02, 0.01])
    deaf = Noted()
    deaf.drive(2)
    deaf.ranges(np.array([5.0]))
    assert (deaf.seen, deaf.steps) == ([], [])


@pytest.mark.parametrize(
    ("position", "sigma"),
    [
        ((math.nan, 1.0), None),
        ((1.0, math.inf), None),
        ((1.0, 1.0), 0.0),
        ((1.0, 1.0), math.inf),
        ((1.0, 1.0), -1.0),
    ],
)
def test_a_fix_that_is_none_is_refused(position: tuple[float, float], sigma: float | None) -> None:
    found = Noted()
    assert not found.fix(np.array(position), sigma)
    assert found.seen == []


def test_a_displacement_counts_from_between_two_steps() -> None:
    found = Noted()
    with pytest.raises(ValueError, match="no origin"):
        _ = found.displacement
    found.drive(3)
    found.set_origin()
    assert found.displacement.mean == pytest.approx([0.0, 0.0, 0.0])
    found.drive(2)
    assert found.displacement.mean == pytest.approx([0.02, 0.0, 0.0])
    found.drive(5)
    assert found.displacement.mean == pytest.approx([0.07, 0.0, 0.0])


def spread_of(errors: ParticleErrors, left: float, right: float, rate: float) -> np.ndarray:
    """Sigmas (3,) of particles along, across, and heading after 4 s, without start errors."""
    exact = errors._replace(start_position=0.0, start_heading=0.0)
    found = ParticleFilter(Pose2(0.0, 0.0, 0.0), exact, count=4000, seed=1)
    for _ in range(160):
        found.predict(np.array([0.0, 0.0, rate]), GRAVITY, np.array([left, right]), 0.025)
    return np.asarray(np.sqrt(np.diag(found.covariance)))


NONE = ParticleErrors(0.0, 0.0)


def test_particles_spread_by_each_figure_as_it_says() -> None:
    """Over 1 m in 40 steps of 0.1 s; a share of each step is drawn again each time."""
    along = spread_of(NONE._replace(forward=0.1), 0.00625, 0.00625, 0.0)
    assert along == pytest.approx([0.1 * math.sqrt(40.0) / 40.0, 0.0, 0.0], rel=0.05, abs=1e-9)
    by_way = spread_of(NONE._replace(along=0.02), 0.00625, 0.00625, 0.0)
    assert by_way == pytest.approx([0.02, 0.0, 0.0], rel=0.05, abs=1e-9)
    turned = spread_of(NONE._replace(turn=0.03), -0.00625, -0.00625, 0.0)
    assert turned[1:] == pytest.approx([0.03 / math.sqrt(3.0), 0.03], rel=0.06)
    by_time = spread_of(NONE._replace(turn_time=0.04), -0.001, 0.001, 0.1)
    assert by_time == pytest.approx([0.0, 0.0, 0.08], rel=0.05, abs=1e-9)


def test_a_slow_error_of_the_fixes_widens_what_they_leave() -> None:
    errors = ParticleErrors(start_position=2.0, gps=0.3, gps_slow=0.4)
    found = ParticleFilter(Pose2(0.0, 0.0, 0.0), errors, count=4000, seed=2)
    found.fix(np.zeros(2))
    left = 1.0 / math.sqrt(1.0 / 2.0**2 + 1.0 / 0.5**2)
    assert np.sqrt(np.diag(found.covariance))[:2] == pytest.approx([left, left], rel=0.06)
