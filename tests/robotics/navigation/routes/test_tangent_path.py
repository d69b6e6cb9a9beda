from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.following.pure_pursuit import PurePursuit
from handcart.robotics.navigation.routes.tangent_path import CarPath, car_path, shortest_detour

RADIUS = 2.0
START, GOAL = Pose2(0.0, 0.0, 0.0), Pose2(12.0, 0.0, 0.0)
NOTHING = np.zeros((0, 3))


def discs(rng: np.random.Generator) -> np.ndarray:
    count = rng.integers(1, 5)
    places = rng.uniform((4.0, -2.5), (8.0, 2.5), (count, 2))
    return np.column_stack([places, rng.uniform(0.5, 1.5, count)])


def steered(path: CarPath) -> np.ndarray:
    """(n, 3) where a car gets that drives the path's curvatures, point by point."""
    pose = Pose2(*path.poses[0].tolist())
    out = [pose]
    for row, bend, before in zip(path.poses[1:], path.curvatures[1:], path.poses[:-1], strict=True):
        chord = math.dist(row[:2], before[:2])
        way = chord if abs(bend) < 1e-9 else 2.0 * math.asin(0.5 * chord * abs(bend)) / abs(bend)
        turn = way * bend
        pose = pose.compose(Pose2(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn))
        out.append(pose)
    return np.array(out)


def test_one_disc_gives_tangent_arc_tangent() -> None:
    """The detour of two tangents and an arc, in closed form."""
    disc = np.array([[5.0, 0.0, 2.5]])
    tangent = math.sqrt(5.0**2 - 2.5**2)
    arc = 2.5 * (math.pi - 2.0 * math.acos(2.5 / 5.0))
    found = shortest_detour(np.zeros(2), np.array([10.0, 0.0]), disc)
    assert found == pytest.approx(2.0 * tangent + arc)


def test_a_free_way_is_straight() -> None:
    assert shortest_detour(np.zeros(2), np.array([3.0, 4.0]), NOTHING) == pytest.approx(5.0)
    path = car_path(START, GOAL, NOTHING, RADIUS)
    assert path is not None
    assert path.length == pytest.approx(12.0)


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, -2.0])
def test_without_obstacles_it_is_dubins(heading: float) -> None:
    """Against OMPL's Dubins curves, where they are of arc, line, arc."""
    base = pytest.importorskip("ompl.base")
    space = base.DubinsStateSpace(RADIUS)
    goal = Pose2(9.0, 4.0, heading)
    states = []
    for pose in (START, goal):
        state = space.allocState()
        state.setXY(pose.x, pose.y)
        state.setYaw(pose.theta)
        states.append(state)
    path = car_path(START, goal, NOTHING, RADIUS)
    assert path is not None
    forward = path.length if path.back_before + path.back_after == 0.0 else math.inf
    assert min(forward, space.distance(*states)) == pytest.approx(space.distance(*states))
    assert path.length <= space.distance(*states) + 1e-6


@pytest.mark.parametrize("seed", range(25))
def test_a_path_can_be_steered_and_keeps_clear(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = discs(rng)
    path = car_path(START, GOAL, obstacles, RADIUS)
    assert path is not None
    gaps = np.hypot(*np.moveaxis(path.poses[:, None, :2] - obstacles[:, :2], -1, 0)) - obstacles[:, 2]
    assert gaps.min() > -1e-3
    assert np.abs(path.curvatures).max() <= 1.0 / RADIUS + 1e-9
    assert path.length >= shortest_detour(np.array(START[:2]), np.array(GOAL[:2]), obstacles) - 1e-6
    end = GOAL.compose(Pose2(path.back_after, 0.0, 0.0))
    assert path.poses[-1, :2] == pytest.approx(end[:2])
    driven = steered(path)
    assert np.abs(driven[:, :2] - path.poses[:, :2]).max() < 0.01
    assert abs(wrap(driven[-1, 2] - end.theta)) < 0.01


def test_before_a_wall_the_car_backs() -> None:
    wall = np.array([[2.6, 0.0, 1.6], [2.6, 2.5, 1.0], [2.6, -2.5, 1.0]])
    path = car_path(START, GOAL, wall, RADIUS)
    assert path is not None
    assert path.back_before > 0.0


def test_no_way_through_a_ring() -> None:
    angles = np.linspace(0.0, 2.0 * math.pi, 20, endpoint=False)
    ring = np.column_stack([6.0 * np.cos(angles), 6.0 * np.sin(angles), np.full(20, 1.2)])
    assert math.isinf(shortest_detour(np.zeros(2), np.array([12.0, 0.0]), ring))
    assert car_path(START, GOAL, ring, RADIUS) is None


@pytest.mark.parametrize("seed", range(5))
def test_pure_pursuit_stays_on_the_path_and_stops_at_its_end(seed: int) -> None:
    path = car_path(START, GOAL, discs(np.random.default_rng(seed)), 1.05 * RADIUS)
    assert path is not None
    control = PurePursuit(path.poses)
    pose, speed, astray, dt = Pose2(*path.poses[0].tolist()), 0.0, 0.0, 0.05
    for _ in range(2000):
        speed, bend = control.command(pose, speed, dt)
        if speed < 1e-3:
            break
        turn = speed * dt * bend
        pose = pose.compose(Pose2(speed * dt * math.cos(turn / 2), speed * dt * math.sin(turn / 2), turn))
        astray = max(astray, control.astray(pose))
    assert math.dist(pose[:2], path.poses[-1, :2]) < 0.03
    assert astray < 0.1
    assert control.left < 0.1


SMALL_ROCKS = (
    (5.24, -2.38, 0.6),
    (5.34, 2.54, 0.82),
    (6.78, 1.18, 0.95),
    (4.38, -0.22, 0.31),
    (7.85, -2.8, 1.74),
)
LATE_TURN = ((5.63, -1.84, 1.82), (8.52, -2.28, 0.77), (8.4, 1.52, 0.9), (7.44, -0.75, 0.78))


@pytest.mark.parametrize("rocks", [SMALL_ROCKS, LATE_TURN])
def test_where_few_circles_give_a_long_way_more_are_tried(
    rocks: tuple[tuple[float, float, float], ...],
) -> None:
    """Between small rocks a wide circle has to lie just right; a quarter of a metre of backing may do."""
    grown = np.array(rocks) + np.array([0.0, 0.0, 0.7])
    path = car_path(START, GOAL, grown, 2.1)
    assert path is not None
    assert path.length < 1.07 * shortest_detour(np.array(START[:2]), np.array(GOAL[:2]), grown)
