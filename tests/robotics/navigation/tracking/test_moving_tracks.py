"""Tracks of people from simulated scans: who moves, how well it is known, and what is no person."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from handcart.backends.simulation.passers.passer_spec import PasserSpec
from handcart.backends.simulation.passers.passers import Passers
from handcart.backends.simulation.sensors.disc_ranges import cast_at_discs
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.world.solids import FloorPlan, of_furniture
from handcart.backends.simulation.world.world_file import Furniture
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.moving_tracks import MovingTracks
from handcart.robotics.navigation.tracking.seen_free import PastScan

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
Boxes = tuple[tuple[float, ...], ...]
PERIOD_S, REACH_M = 0.05, 6.0
POSE_COVARIANCE = np.diag([1e-4, 1e-4, 1e-5])


def scans(
    passers: list[dict[str, Any]],
    seconds: float,
    boxes: Boxes = (),
    speed: float = 0.0,
) -> Iterator[tuple[Passers, MovingTracks, Any]]:
    """Track what a lidar sees that drives along x; boxes are x, y, length, width."""
    rng = np.random.default_rng(5)
    walkers = Passers([PasserSpec.model_validate(each) for each in passers], 0)
    pieces = [
        Furniture(name="box", x_m=x, y_m=y, size_m=(length, width, 1.0)) for x, y, length, width in boxes
    ]
    plan, tracks = FloorPlan([of_furniture(each) for each in pieces], 0.3, 0.3), MovingTracks(REACH_M)
    for period in range(1, round(seconds / PERIOD_S) + 1):
        time = period * PERIOD_S
        sensor = Pose2(speed * time, 0.0, 0.0)
        walkers.advance(time, PERIOD_S, Pose2(50.0, 50.0, 0.0), 0.2)
        ranges = cast_rays(plan, sensor, ANGLES, time, 12.0)
        ranges = np.minimum(ranges, cast_at_discs(walkers.discs(0.3), sensor, ANGLES, 12.0))
        ranges = ranges + 0.01 * rng.standard_normal(len(ranges))
        hit = np.isfinite(ranges)
        rays = np.column_stack([np.cos(ANGLES[hit]), np.sin(ANGLES[hit])])
        points = sensor.apply(ranges[hit, None] * rays)
        found = tracks.take(points, PastScan(time, sensor, ANGLES, ranges), POSE_COVARIANCE)
        yield walkers, tracks, (time, points, found)


def test_walking_person_is_tracked_as_well_as_claimed() -> None:
    anna = {"name": "anna", "waypoints_m": [[3.0, -4.0], [2.0, 4.0]], "at_end": "stay"}
    nees, speeds = [], []
    for walkers, tracks, (time, _, _) in scans([anna], 5.0):
        step = walkers.steps()[0][2]
        if time > 1.0:
            (track,) = tracks.tracks
            off = np.append(track.position - step.position, track.velocity - step.speed * step.direction)
            nees.append(off @ np.linalg.solve(track.covariance, off))
            speeds.append(np.hypot(*track.velocity))
    assert 1.0 < np.mean(nees) < 6.0  # 4 for white noise; legs swing, and are no white noise
    assert np.percentile(nees, 95) < 13.3  # 99 % of a claimed covariance
    assert abs(np.mean(speeds) - 1.2) < 0.1


def test_two_who_cross_keep_their_tracks() -> None:
    crossing = [
        {"name": "anna", "waypoints_m": [[2.5, -3.0], [2.5, 3.0]], "at_end": "stay"},
        {"name": "bert", "waypoints_m": [[3.6, 3.0], [3.6, -3.0]], "at_end": "stay"},
    ]
    walkers, tracks = Passers(), MovingTracks(REACH_M)
    for walkers, tracks, (time, _, _) in scans(crossing, 4.5):  # noqa: B007
        if 1.0 < time < 2.0:
            before = {each.number: each.velocity[1] > 0.0 for each in tracks.tracks}
    assert len(before) == 2
    after = {each.number: each.velocity[1] > 0.0 for each in tracks.tracks}
    assert walkers.steps()[0][2].position[1] > 2.0
    assert after == before


def test_pair_side_by_side_is_two_persons() -> None:
    pair = {"name": "pair", "waypoints_m": [[2.5, -3.0], [2.5, 3.0]], "group_m": [0.7], "at_end": "stay"}
    for _, tracks, (time, _, _) in scans([pair], 3.5):
        if time > 1.5:
            assert len(tracks.tracks) == 2


def test_things_that_stand_are_no_people_as_the_robot_passes() -> None:
    stand: Boxes = (
        (2.0, 1.0, 0.3, 0.3),
        (3.0, 1.4, 0.8, 0.4),
        (3.0, -0.8, 0.05, 0.05),
        (3.4, -0.8, 0.05, 0.05),
    )
    stand += ((4.5, -1.2, 0.4, 0.4), (4.9, 1.1, 0.2, 0.6), (5.5, -1.6, 0.3, 0.3), (6.0, 1.2, 0.3, 0.3))
    for _, tracks, _ in scans([], 6.0, stand, speed=1.0):
        assert tracks.tracks == []


def test_points_of_a_walker_are_moving_and_what_it_left_is_reported() -> None:
    anna = {"name": "anna", "waypoints_m": [[3.0, -2.0], [3.0, 3.0]], "at_end": "stay"}
    left = []
    tracks = MovingTracks(REACH_M)
    for walkers, tracks, (time, points, found) in scans([anna], 7.0, ((-2.0, 2.0, 0.4, 0.4),)):  # noqa: B007
        near = np.hypot(*(points - walkers.steps()[0][2].position).T) < 0.5
        left += found.left[:, :2].tolist()
        if 1.0 < time < 4.0:
            assert found.moving[near].all()
            assert not found.moving[~near].any()
    assert not found.moving.any()  # it has stood for 2 s and more, and is an obstacle now
    assert [each.is_moving for each in tracks.tracks] == [False]
    assert np.hypot(*(np.array(left) - (3.0, -2.0)).T).min() < 0.2


def test_who_left_is_forgotten_and_who_is_hidden_is_remembered() -> None:
    anna = {"name": "anna", "waypoints_m": [[3.0, -2.0], [3.0, 4.0]], "at_end": "stay"}
    hidden = []
    for walkers, tracks, (time, points, _) in scans([anna], 4.0, ((1.5, 0.5, 0.1, 0.4),)):
        step = walkers.steps()[0][2]
        if time > 1.0 and not (np.hypot(*(points - step.position).T) < 0.5).any():
            (track,) = tracks.tracks
            hidden.append(np.hypot(*(track.position - step.position)))
    assert 3 < len(hidden) < 20
    assert max(hidden) < 0.4
