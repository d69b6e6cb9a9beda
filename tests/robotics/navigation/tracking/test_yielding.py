"""Speeds with which a base yields to people."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.tracking.moving_tracks import STOOD_S
from handcart.robotics.navigation.tracking.people import (
    CLEAR_OF_ROBOT_M,
    FORESEEN_S,
    FORESEEN_STEP_S,
    MAX_SPREAD_M,
    People,
    least_gaps,
    with_people,
)
from handcart.robotics.navigation.tracking.yielding import (
    AWAY_GAP_M,
    CREEPING_M_S,
    MOVING_GAP_M,
    REACTION_S,
    SETTLED_S,
    SPEED_SHARES,
    STANDING_GAP_M,
    STEP_OUT_SPEED_M_S,
    STEP_S,
    TURN_BACK_S,
    TURN_BACK_SPEED_M_S,
    safe_share,
    yielding_speed,
)

HERE = Pose2(0.0, 0.0, 0.0)


def somebody(x: float, y: float, vx: float, vy: float, stood_s: float = 0.0) -> People:
    """Return one person whose position is known to 5 cm."""
    covariance = np.diag([0.0025, 0.0025, 0.01, 0.01])[None]
    return People(np.array([[x, y]]), np.array([[vx, vy]]), covariance, np.array([0.25]), np.array([stood_s]))


@pytest.mark.parametrize(
    ("person", "low", "high"),
    [
        (somebody(1.0, 0.0, -1.2, 0.0), 0.0, 0.0),  # comes towards the base
        (somebody(0.8, -0.9, 0.0, 1.2), 0.0, 0.3),  # in front before the base can stop
        (somebody(-0.7, 0.0, 1.2, 0.0), 0.0, 0.0),  # comes from behind: stop
        (somebody(5.0, 0.0, -1.2, 0.0), 1.0, 1.0),
        (somebody(0.0, 2.5, 0.0, 1.2), 1.0, 1.0),  # walks away
        (somebody(-0.5, 0.0, 0.0, 0.0, 5.0), 0.1, 0.3),  # close behind, at rest: the base may leave
        (somebody(-0.5, 0.0, 0.0, 0.0, 2.0), 0.0, 0.0),  # at rest for a moment: may walk again at once
        (somebody(1.45, 0.0, 0.3, 0.0), 0.0, 0.7),  # walks away, and would be met if she turned back
    ],
)
def test_share_of_a_command_leads_into_nobody(person: People, low: float, high: float) -> None:
    assert low <= safe_share(HERE, (0.6, 0.0), person, 0.22, 0.6, 0.05) <= high


def test_speed_along_a_route_lets_the_crossing_pass() -> None:
    ahead = np.array([[0.0, 0.0], [6.0, 0.0]])
    crossing = somebody(1.5, -1.8, 0.0, 1.2)
    assert yielding_speed(ahead, 1.0, crossing, 0.22, 0.5) <= 0.45
    assert yielding_speed(ahead, 1.0, somebody(1.5, 1.2, 0.0, 1.2), 0.22, 0.5) == 1.0


def crowd(rng: np.random.Generator) -> People:
    """Return up to six people near the base, some of them at rest."""
    count = int(rng.integers(1, 7))
    root = 0.05 * rng.standard_normal((count, 4, 4))
    velocities = rng.standard_normal((count, 2)) * (rng.random(count) < 0.6)[:, None]
    stood_s = np.where((velocities != 0.0).any(axis=1), 0.0, rng.uniform(0.0, 6.0, count))
    sizes = rng.uniform(0.27, 0.4, count)
    return People(rng.normal(0.0, 1.5, (count, 2)), velocities, root @ root.mT, sizes, stood_s)


def is_safe(share: float, command: tuple[float, float], people: People, braking: float) -> bool:
    """Return whether a share of a command is safe, person by person, computed with `least_gaps`."""
    speed = share * abs(command[0])
    end = 0.05 + speed / braking + REACTION_S
    times = np.append(np.arange(0.0, end, STEP_S), end)
    after = np.clip(times - 0.05, 0.0, speed / braking)
    along = speed * np.minimum(times, 0.05) + speed * after - 0.5 * braking * after**2
    turned = command[1] / abs(command[0]) * along
    bend = max(abs(command[1] / command[0]), 1e-9) * math.copysign(1.0, command[1])
    arc = np.column_stack([np.sin(turned) / bend, (1.0 - np.cos(turned)) / bend])
    arc *= math.copysign(1.0, command[0])
    gaps = least_gaps(np.stack([arc, np.zeros_like(arc)]), times, people, 0.22)
    near = least_gaps(arc[None], np.zeros(len(times)), people, 0.22)[0]
    for gap, standing, now, moves, stood_s in zip(*gaps, near, people.moving, people.stood_s, strict=True):
        leaves = gap >= standing - 1e-3 and (gap >= AWAY_GAP_M or stood_s >= STOOD_S)
        creeps = leaves and stood_s >= SETTLED_S and speed <= CREEPING_M_S
        sudden = TURN_BACK_SPEED_M_S if stood_s < SETTLED_S else STEP_OUT_SPEED_M_S
        in_time = now >= sudden * (speed / braking + TURN_BACK_S)
        has_room = gap >= (MOVING_GAP_M if moves else STANDING_GAP_M)
        if not ((has_room or leaves) and (in_time or creeps)):
            return False
    return True


def test_safe_share_is_the_first_that_is_safe_for_each_person() -> None:
    rng, found = np.random.default_rng(5), set()
    for _ in range(300):
        people, braking = crowd(rng), float(rng.uniform(0.3, 1.5))
        command = float(rng.uniform(0.05, 1.2) * rng.choice([-1.0, 1.0])), float(rng.normal(0.0, 0.8))
        shares = [share for share in SPEED_SHARES[:-1] if is_safe(share, command, people, braking)]
        found.add(safe_share(HERE, command, people, 0.22, braking, 0.05))
        assert safe_share(HERE, command, people, 0.22, braking, 0.05) == max(shares, default=0.0)
    assert found == set(SPEED_SHARES)


def test_a_base_brakes_no_harder_than_a_foreseen_person_needs() -> None:
    """It drives towards a crossing of ways, and each period's braking is enough for the next one."""
    speed, x, braking, period, slower = 1.0, 0.0, 0.8, 0.05, 0
    for i in range(60):
        person = somebody(3.4, -3.0 + 0.05 * i, 0.0, 1.0)
        wanted = min(1.0, speed + braking * period)
        share = safe_share(Pose2(x, 0.0, 0.0), (wanted, 0.0), person, 0.22, braking, period, speed)
        assert share * wanted > speed - braking * period - 1e-9
        slower += share < 1.0
        speed = share * wanted
        x += speed * period
    assert slower > 3


def test_a_person_who_is_seen_too_late_is_braked_for_at_once() -> None:
    person = somebody(1.0, 0.0, -1.2, 0.0)
    assert safe_share(HERE, (1.0, 0.0), person, 0.22, 0.8, 0.05, 1.0) == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_people_are_drawn_where_they_are_and_will_be(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = rng.random((60, 80)) < 0.05
    grid = GridMap(occupied, np.zeros_like(occupied), 0.05, -2.0, -1.5)
    people, here = crowd(rng), np.array([0.5, 0.2])
    drawn = with_people(grid, people, here, 0.22, 0.3).occupied
    cells = np.argwhere(np.ones_like(occupied))
    centres = grid.to_point(cells)
    expected = occupied.copy()
    for number in range(len(people.radii)):
        times = np.arange(0.0, FORESEEN_S + 1e-9, FORESEEN_STEP_S) * people.moving[number]
        spreads = np.minimum(people.spreads(times)[number], MAX_SPREAD_M)
        for time, spread in zip(times, spreads, strict=True):
            middle = people.positions[number] + time * people.velocities[number]
            near = np.hypot(*(centres - middle).T) <= people.radii[number] + 0.3 + spread
            expected |= near.reshape(expected.shape)
    beside = np.hypot(*(centres - here).T).reshape(expected.shape) <= 0.22 + CLEAR_OF_ROBOT_M
    assert np.array_equal(drawn, np.where(beside, occupied, expected))
    assert drawn.sum() > occupied.sum()
