"""Tracks of people from simulated scans: moving persons, their accuracy, and things that are not persons."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.passers.passers import Passers
from handcart.robotics.navigation.tracking.moving_tracks import MovingTracks

from .walkers import PERIOD_S, REACH_M, Boxes, scans

PAUSES: dict[str, Any] = {
    "name": "anna",
    "waypoints_m": [[2.2, -1.5], [2.2, 0.0], [2.2, 1.5]],
    "pauses_s": [0.0, 2.5, 0.0],
}
TURNS_BACK: dict[str, Any] = {"name": "bert", "waypoints_m": [[3.0, 0.2], [1.4, 0.2]]}
GROUP: dict[str, Any] = {"name": "trio", "waypoints_m": [[1.5, -2.0], [1.5, 2.0]], "group_m": [0.7, -0.7]}
STAYS: dict[str, Any] = {"name": "emma", "waypoints_m": [[1.3, -2.0], [1.3, 0.1]], "at_end": "stay"}
PASSES: dict[str, Any] = {"name": "finn", "waypoints_m": [[1.7, -1.9], [1.75, 2.5]], "at_end": "stay"}
CROSSES: dict[str, Any] = {"name": "dora", "waypoints_m": [[2.6, 1.6], [2.6, -1.6]]}


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
    assert 1.0 < np.mean(nees) < 6.0  # 4 for white noise; the error of swinging legs is not white
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
            before = {track.number: track.velocity[1] > 0.0 for track in tracks.tracks}
    assert len(before) == 2
    after = {track.number: track.velocity[1] > 0.0 for track in tracks.tracks}
    assert walkers.steps()[0][2].position[1] > 2.0
    assert after == before


def test_pair_side_by_side_is_two_persons() -> None:
    pair = {"name": "pair", "waypoints_m": [[2.5, -3.0], [2.5, 3.0]], "group_m": [0.7], "at_end": "stay"}
    for _, tracks, (time, _, _) in scans([pair], 3.5):
        if time > 1.5:
            assert len(tracks.tracks) == 2


@pytest.mark.parametrize("jump_m", [0.0, 0.2])
def test_things_that_stand_are_no_people_as_the_robot_passes(jump_m: float) -> None:
    stand: Boxes = (
        (2.0, 1.0, 0.3, 0.3),
        (3.0, 1.4, 0.8, 0.4),
        (3.0, -0.8, 0.05, 0.05),
        (3.4, -0.8, 0.05, 0.05),
    )
    stand += ((4.5, -1.2, 0.4, 0.4), (4.9, 1.1, 0.2, 0.6), (5.5, -1.6, 0.3, 0.3), (6.0, 1.2, 0.3, 0.3))
    for _, tracks, _ in scans([], 6.0, stand, speed=1.0, jump_m=jump_m):
        assert tracks.tracks == []
        assert tracks.suspects == []


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
    assert not found.moving.any()  # at rest for 2 s and more: an obstacle now
    assert [track.is_moving for track in tracks.tracks] == [False]
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


@pytest.mark.parametrize(
    "walks", [[PAUSES], [TURNS_BACK], [GROUP], [PAUSES, CROSSES], [TURNS_BACK, CROSSES], [STAYS, PASSES]]
)
def test_somebody_in_view_is_never_unknown_for_long(walks: list[dict[str, Any]]) -> None:
    """A person who walks, stops, turns back or passes others has a track, or is a suspect."""
    unknown: dict[str, int] = {}
    for walkers, tracks, (time, points, _) in scans(walks, 9.0):
        known = [track.position for track in (*tracks.tracks, *tracks.suspects)]
        for name, _, step in walkers.steps():
            seen = (np.hypot(*(points - step.position).T) < 0.35).sum() >= 4
            near = any(np.hypot(*(at - step.position)) < 0.4 for at in known)
            unknown[name] = 0 if near or not seen or time < 0.7 else unknown.get(name, 0) + 1
            assert unknown[name] * PERIOD_S <= 0.25, (name, time)


def test_person_who_starts_again_after_a_rest_is_noticed_at_once() -> None:
    seen_at = None
    for walkers, tracks, (time, _, _) in scans([PAUSES], 4.5):
        step = walkers.steps()[0][2]
        walked = step.position[1] if time > 2.0 else -1.0
        (track,) = tracks.tracks if time > 1.0 else (None,)
        if track is not None and walked > 0.0 and track.stood_s < 0.2:
            seen_at = walked
            break
    assert seen_at is not None
    assert seen_at < 0.3  # a quarter of a second at 1.2 m/s
