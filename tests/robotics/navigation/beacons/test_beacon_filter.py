"""Ranges to beacons: the place and each beacon's bias, also where a bias isn't what is supposed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.field.beacons import (
    BEACON_ERRORS,
    BEACON_POSITIONS_M,
    BeaconDrive,
    BeaconWorld,
    beacon_drive,
    try_beacons,
)
from benchmarks.field.displacements import true_way
from benchmarks.field.field_drive import PERIOD_S
from handcart.backends.plain_values import attributes, set_attributes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.beacons.beacon_errors import BeaconErrors
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.placement_errors import nees

CONSTANT = BEACON_ERRORS._replace(bias_walk=0.0)


@pytest.fixture(scope="module")
def drives() -> list[BeaconDrive]:
    return [beacon_drive(seed, stops=3) for seed in range(5)]


@pytest.mark.slow
def test_the_place_is_known_although_each_beacon_is_off(drives: list[BeaconDrive]) -> None:
    trials = [try_beacons(drive, CONSTANT) for drive in drives]
    errors = np.concatenate([trial.errors for trial in trials])
    squares = nees(errors, np.concatenate([trial.covariances for trial in trials]))
    assert np.quantile(np.hypot(*errors.T), 0.95) < 0.10
    assert 1.0 < squares.mean() < 3.2
    assert all(all(trial.consistent) for trial in trials)
    assert max(trial.refused for trial in trials) < 0.001


@pytest.mark.slow
def test_who_supposes_no_bias_is_wrong_and_hears_so(drives: list[BeaconDrive]) -> None:
    trials = [try_beacons(drive, BEACON_ERRORS._replace(bias=0.005, bias_walk=0.0)) for drive in drives]
    errors = np.concatenate([trial.errors for trial in trials])
    assert np.quantile(np.hypot(*errors.T), 0.95) > 0.15
    assert not all(all(trial.consistent) for trial in trials)


@pytest.mark.slow
def test_biases_are_found_as_well_as_is_claimed(drives: list[BeaconDrive]) -> None:
    squares = []
    for drive in drives:
        filtering = BeaconFilter(Pose2(0.0, 0.0, drive.log.start_heading), REFERENCE_NOISE, CONSTANT)
        for row in range(len(drive.log.rates)):
            readings = drive.log.rates[row], drive.log.accelerations[row], drive.log.wheels[row]
            filtering.predict(*readings, PERIOD_S)
            filtering.ranges(drive.ranges[row])
        mean, covariance = filtering.biases
        off = mean - drive.biases
        squares.append(off @ np.linalg.solve(covariance, off))
        assert np.abs(off).max() < 0.2
    assert 1.2 < np.mean(squares) < 6.0  # 3 on average


@pytest.mark.slow
def test_a_scale_of_all_ranges_is_found() -> None:
    """The scale is that of a lawn mower's radios, which measured 7 % too much."""
    drive = beacon_drive(3)
    long = drive._replace(ranges=1.07 * drive.ranges)
    wary, sure = (try_beacons(long, BEACON_ERRORS._replace(scale=scale)) for scale in (0.1, 0.002))
    assert np.hypot(*wary.errors.T).max() < 0.4
    assert nees(wary.errors, wary.covariances).mean() < 6.0
    assert np.hypot(*sure.errors.T).max() > 2.0 * np.hypot(*wary.errors.T).max()


@pytest.mark.slow
@pytest.mark.parametrize("world", [BeaconWorld(bias_walk=0.01), BeaconWorld(moved=0.5)])
def test_claims_hold_where_a_bias_is_not_constant(world: BeaconWorld) -> None:
    """Wandering, or as a beacon is moved a little; without the walk that is supposed they don't."""
    sure, wary = list[np.ndarray](), list[np.ndarray]()
    for seed in range(2):
        drive = beacon_drive(seed, world)
        for errors, found in ((BEACON_ERRORS, wary), (CONSTANT, sure)):
            trial = try_beacons(drive, errors)
            found.append(nees(trial.errors, trial.covariances))
    assert np.mean(wary) < 4.0
    assert np.mean(sure) > 5.0


@pytest.mark.slow
def test_a_beacon_that_was_carried_off_is_not_believed(drives: list[BeaconDrive]) -> None:
    """From the start on; the other two of three suffice with wheels and gyros."""
    drive = drives[0]
    ranges = drive.ranges.copy()
    ranges[:, 0] += 15.0
    trial = try_beacons(drive._replace(ranges=ranges))
    assert 0.0 < trial.refused < 0.05
    assert np.hypot(*trial.errors.T).max() < 0.4
    ranges[:, 1] -= 15.0
    assert not all(try_beacons(drive._replace(ranges=ranges)).consistent)


@pytest.mark.slow
def test_claims_hold_where_a_beacon_is_moved_by_metres_on_the_way() -> None:
    """Refused at first, its ranges would come to fit a wrong place as the robot drives on."""
    trials = [try_beacons(beacon_drive(seed, BeaconWorld(moved=3.0))) for seed in range(2)]
    squares = np.concatenate([nees(trial.errors, trial.covariances) for trial in trials])
    assert squares.mean() < 2.0
    assert squares.max() < 9.0
    assert all(0.0 < trial.refused < 0.02 for trial in trials)


def test_where_the_claim_is_wrong_no_beacon_is_left_out(drives: list[BeaconDrive]) -> None:
    """A robot that was carried off: all ranges are refused on and on. What is out of reach tells nothing."""
    drive = drives[1]
    unheard = np.full((len(drive.ranges), 2), math.nan)
    ranges = np.c_[drive.ranges, unheard]
    ranges[2000:, :3] += (15.0, -15.0, 15.0)
    places = np.vstack([BEACON_POSITIONS_M, [[500.0, 0.0, 2.0], [0.0, 500.0, 2.0]]])
    trial = try_beacons(
        drive._replace(ranges=ranges, biases=np.zeros(5)), BEACON_ERRORS._replace(places=places)
    )
    assert trial.refused > 0.3
    assert not all(trial.consistent)


@pytest.mark.slow
def test_a_beacon_that_is_hidden_for_a_while_is_believed_again(drives: list[BeaconDrive]) -> None:
    """Ranges by way of a wall are too long; five seconds of them leave nobody out."""
    drive = drives[2]
    hidden, ranges = slice(3000, 3000 + round(5.0 / PERIOD_S)), drive.ranges.copy()
    ranges[hidden, 0] += 20.0
    trial = try_beacons(drive._replace(ranges=ranges))
    ranges[hidden.stop :, 0] = math.nan
    without = try_beacons(drive._replace(ranges=ranges))
    assert trial.refused > 0.0
    assert np.trace(trial.covariances[-1]) < np.trace(without.covariances[-1])


def test_what_is_not_heard_tells_nothing(drives: list[BeaconDrive]) -> None:
    """Ranges that are not finite, and a tag right below a beacon, where the range gives no direction."""
    log = drives[0].log
    errors = BEACON_ERRORS._replace(places=np.array([[0.0, 0.0, 2.0]]))
    one, other = (BeaconFilter(Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE, errors) for _ in range(2))
    for row in range(200):
        for item in (one, other):
            item.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        one.ranges(np.array([math.nan if row % 2 else math.inf]))
    assert np.allclose(one.covariance, other.covariance)
    other.ranges(np.array([1.2]))
    assert np.isfinite(other.covariance).all()
    assert one.pose.distance(other.pose) < 0.1
    assert one.fix(np.zeros(2)) is False


def test_how_far_it_came_and_a_checkpoint_that_keeps_it(drives: list[BeaconDrive]) -> None:
    drive, begin = drives[1], 2400
    end = int(drive.log.drive.placings[0])
    log = drive.log
    first, second = (
        BeaconFilter(Pose2(0.0, 0.0, log.start_heading), REFERENCE_NOISE, BEACON_ERRORS) for _ in range(2)
    )
    for row in range(end):
        if row == begin:
            first.set_origin()
        first.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        first.ranges(drive.ranges[row])
    mean, covariance = first.displacement
    off = mean[:2] - true_way(log, begin, end - 1)[:2]
    assert nees(off[None], covariance[None, :2, :2])[0] < 14.0
    for before, after in ((first, second), (first.odometry, second.odometry)):
        set_attributes(after, after.STATE, attributes(before, before.STATE))
    assert first.pose == second.pose
    for one, other in zip(first.displacement, second.displacement, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("tag", [(0.0, 0.0, 1.0), (0.8, -0.4, 1.2)])
@pytest.mark.parametrize("heading", [0.0, 2.2])
def test_a_range_corrects_by_the_derivative_of_its_distance(
    tag: tuple[float, float, float], heading: float
) -> None:
    """Against differences: of the place, and through the tag's lever of the heading, too."""
    place, start = np.array([6.0, 4.0, 2.5]), Pose2(1.0, 1.0, heading)
    errors = BeaconErrors(place[None], tag, white=0.05, bias=0.2, scale=0.01)
    noise = REFERENCE_NOISE._replace(start_heading=0.1)
    filtering = BeaconFilter(start, noise, errors, start_position=0.3)

    def distance(x: float, y: float, theta: float) -> float:
        at = Pose2(x, y, theta).apply(np.array([tag[:2]]))[0]
        return math.hypot(*(place[:2] - at), place[2] - tag[2])

    expected, row = distance(*start), np.zeros(3)
    for k in range(3):
        aside = 1e-6 * np.eye(3)[k]
        row[k] = (distance(*(start + aside)) - distance(*(start - aside))) / 2e-6
    prior = np.diag([0.3, 0.3, 0.1]) ** 2
    variance = row @ prior @ row + 0.2**2 + (0.01 * expected) ** 2 + 0.05**2
    gain = prior @ row / variance
    filtering.ranges(np.array([expected + 0.3]))
    assert filtering.covariance == pytest.approx(prior - np.outer(gain, gain) * variance)
    moved = np.array(filtering.pose) - start
    assert moved == pytest.approx(0.3 * gain)
    assert filtering.biases.mean == pytest.approx([0.3 * 0.2**2 / variance])
    assert filtering.biases.covariance[0, 0] == pytest.approx(0.2**2 - 0.2**4 / variance)


@pytest.mark.parametrize(("sigmas", "refused"), [(4.99, 0), (5.01, 1), (-5.01, 1)])
def test_a_range_is_refused_beyond_five_of_its_sigmas(sigmas: float, refused: int) -> None:
    errors = BeaconErrors(np.array([[5.0, 0.0, 1.0]]), (0.0, 0.0, 1.0), 0.1, 0.3, 0.01)
    filtering = BeaconFilter(Pose2(0.0, 0.0, 0.0), REFERENCE_NOISE, errors, 0.2)
    sigma = math.sqrt(0.1**2 + 0.3**2 + 0.05**2 + 0.2**2)
    filtering.ranges(np.array([5.0 + sigmas * sigma]))
    assert filtering.refused == refused
    assert (filtering.pose.x == 0.0) == (refused == 1)
