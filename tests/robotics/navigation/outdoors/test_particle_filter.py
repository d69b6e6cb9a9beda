import math

import numpy as np
import pytest

from benchmarks.field.field_course import zigzag_course
from benchmarks.field.field_log import record_course
from benchmarks.field.field_trial import start_pose, try_course
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.particle_filter import ParticleErrors, ParticleFilter
from handcart.robotics.navigation.outdoors.placement_errors import aligned_spread

DT = 0.025
LEVEL = np.array([0.0, 0.0, 9.81])


def drive(localizer: ParticleFilter, seconds: float, speed: float = 0.5, rate: float = 0.0) -> None:
    for _ in range(round(seconds / DT)):
        localizer.predict(np.array([0.0, 0.0, rate]), LEVEL, np.full(2, speed * DT), DT)


@pytest.mark.slow
def test_it_spreads_like_the_papers_field_test() -> None:
    """A few runs only: the benchmark has them all."""
    course = zigzag_course()
    spreads = []
    for seed in range(10):
        log = record_course(course, REFERENCE_NOISE, seed)
        trial = try_course(log, ParticleFilter(start_pose(log), seed=seed, euler=False))
        spreads.append(aligned_spread(trial.errors, course.targets))
    low, high = np.percentile(spreads, [10, 90], axis=0)
    assert (low < [0.283, 0.123]).all()
    assert (high > [0.283, 0.123]).all()


def test_particles_spread_with_the_way() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0))
    before = localizer.covariance
    drive(localizer, 20.0)
    after = localizer.covariance
    assert localizer.pose.x == pytest.approx(10.0, abs=0.05)
    assert math.sqrt(after[2, 2] - before[2, 2]) == pytest.approx(math.radians(0.5), rel=0.2)
    assert after[1, 1] > 10 * before[1, 1]


def test_fixes_pull_and_jumps_do_not() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_position=2.0))
    before = localizer.covariance[0, 0]
    assert localizer.fix(np.array([1.0, 0.0]))
    assert localizer.pose.x > 0.5
    assert localizer.covariance[0, 0] < before
    there = localizer.pose
    assert not localizer.fix(np.array([40.0, 0.0]))
    assert not localizer.fix(np.array([np.nan, 0.0]))
    assert not localizer.fix(np.zeros(2), sigma=0.0)
    assert localizer.pose == pytest.approx(there)


def test_the_mean_heading_is_taken_on_the_circle() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, math.pi), ParticleErrors(start_heading=0.2))
    drive(localizer, 1.0, rate=0.5)
    assert abs(abs(localizer.pose.theta) - (math.pi - 0.5)) < 0.05
    assert math.sqrt(localizer.covariance[2, 2]) == pytest.approx(0.2, rel=0.1)


def test_there_is_a_new_pose_each_period() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0))
    seen = []
    for _ in range(8):
        drive(localizer, DT)
        seen.append(localizer.pose.x)
    assert np.diff(seen) == pytest.approx(0.0125, abs=0.005)


def test_the_same_seed_and_a_restored_one_give_the_same_run() -> None:
    first, again = (ParticleFilter(Pose2(0.0, 0.0, 0.0), seed=4) for _ in range(2))
    drive(first, 2.0)
    again.dice = first.dice
    for name in ParticleFilter.STATE:
        setattr(again, name, getattr(first, name))
    again._particles = first.particles
    for name in first.odometry.STATE:
        setattr(again.odometry, name, getattr(first.odometry, name).copy())
    for localizer in (first, again):
        localizer.fix(np.array([1.2, 0.1]))
        drive(localizer, 2.0)
    assert np.array_equal(first.particles, again.particles)


EXACT = ParticleErrors(forward=0.0, turn=0.0, start_position=0.0, start_heading=0.0)


def test_an_arc_ends_where_an_arc_ends() -> None:
    """Each step turns by its half before it goes."""
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), EXACT, count=4)
    drive(localizer, 4.0, speed=0.5, rate=0.5)
    assert localizer.pose.x == pytest.approx(math.sin(2.0), abs=2e-3)
    assert localizer.pose.y == pytest.approx(1.0 - math.cos(2.0), abs=2e-3)


@pytest.mark.parametrize(
    ("sigma", "mean", "variance"), [(1.0, 0.8, 0.8), (0.5, 0.941, 0.235), (4.0, 0.2, 3.2)]
)
def test_a_fix_leaves_what_bayes_says(sigma: float, mean: float, variance: float) -> None:
    """Of a normal spread and a normal fix: weights, draws and the fix's own sigma all count in it."""
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_position=2.0), count=20_000, seed=3)
    assert localizer.fix(np.array([1.0, 0.0]), sigma)
    assert localizer.pose.x == pytest.approx(mean, abs=0.06)
    assert localizer.covariance[0, 0] == pytest.approx(variance, rel=0.08)
    assert localizer.covariance[1, 1] == pytest.approx(variance, rel=0.08)


@pytest.mark.parametrize(("away", "believed"), [(4.5, True), (5.5, False)])
def test_a_fix_is_a_jump_beyond_five_of_its_sigmas(away: float, believed: bool) -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_position=0.05))
    assert localizer.fix(np.array([away, 0.0])) == believed
    other = ParticleFilter(Pose2(0.0, 0.0, 0.0), ParticleErrors(start_position=0.05))
    assert other.fix(np.array([1.5 * away, 0.0]), sigma=2.0)


def test_headings_that_are_anyhow_vary_no_more_than_on_a_circle() -> None:
    localizer = ParticleFilter(Pose2(0.0, 0.0, 1.0), ParticleErrors(start_heading=6.0))
    assert localizer.covariance[2, 2] == pytest.approx(math.pi**2 / 3, rel=0.1)
