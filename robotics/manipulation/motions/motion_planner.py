"""Paths of an arm from one posture to another, free of collisions, and straight lines of its hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

LIMIT_ROUNDING = 1e-6
"""Tolerance beyond a joint limit, in [rad] or [m], for the rounding of a trajectory that ends there."""


def plan_motion(
    arm: ArmModel,
    collision: CollisionModel,
    q_start: FloatArray,
    q_goal: FloatArray,
    seed: int = 0,
    max_branches: int = 4000,
    step: float = 0.01,
) -> FloatArray | None:
    """Return a collision-free path of straight joint lines between postures; None if none was found.

    The straight line is returned if it is free. Otherwise a path is searched by RRT-Connect (Kuffner and
    LaValle 2000, implemented in OMPL) within the joint limits, and shortened. Continuous joints turn the
    shorter way, so the path may end at `q_goal` plus full turns. If no path is found, one continuous joint
    after the other turns the longer way. The same seed gives the same path, because the effort is bounded by
    the number of lines, not by time.

    Args:
        arm: kinematics of the arm.
        collision: bodies to keep clear of.
        q_start: (n,) joint angles at the start, in [rad] or [m].
        q_goal: (n,) joint angles at the goal, in [rad] or [m].
        seed: seed of the search.
        max_branches: maximum number of lines tried for each choice of turns.
        step: distance of checks on a line, in [rad] or [m].

    Returns:
        Waypoints (m, n) in [rad] or [m]; None also if an end is in collision (`collision.contacts` names the
        pairs) or beyond the limits.
    """
    if not (arm.within(q_start, LIMIT_ROUNDING) and arm.within(q_goal, LIMIT_ROUNDING)):
        return None
    q_start, q_goal = arm.clipped(q_start), arm.clipped(q_goal)
    q_goal = arm.nearest(q_goal, q_start)
    if collision.in_collision(q_start) or collision.in_collision(q_goal):
        return None
    goals = [q_goal, *_longer_ways(arm, q_start, q_goal)]
    for goal in goals:
        if collision.line_free(q_start, goal, step):
            return np.array([q_start, goal])
    found = None
    for goal in goals:
        found = _rrt_connect(arm, collision, q_start, goal, seed, max_branches, step)
        if found is not None:
            break
    if found is None:
        return None
    return _shorten(found, _remembering(collision, step), seed)


def plan_straight(
    arm: ArmModel,
    q_start: FloatArray,
    base_T_goal: Transform,
    step: float = 0.005,
    collision: CollisionModel | None = None,
) -> FloatArray | None:
    """Return joint angles that move the tip in a straight line to a pose; None if that is not possible.

    Args:
        arm: kinematics of the arm.
        q_start: (n,) joint angles at the start, in [rad] or [m].
        base_T_goal: (4, 4) pose of the tip at the end.
        step: largest motion of the tip from one row to the next, in [m]; per step the tip turns by at most 10
            rad for each metre of `step`.
        collision: bodies to keep clear of; None: collisions are not checked.

    Returns:
        (m, n) in [rad] or [m]; None if a pose on the line can't be reached without a jump of the joints to
        another configuration, or if the arm collides.
    """
    start, goal = pin.SE3(arm.forward(q_start)), pin.SE3(base_T_goal)
    motion = pin.log6(start.actInv(goal)).vector
    distance = float(np.linalg.norm(goal.translation - start.translation))
    count = max(1, int(np.ceil(max(distance, float(np.linalg.norm(motion[3:])) / 10.0) / step)))
    path = [np.asarray(q_start, dtype=np.float64)]
    for index in range(1, count + 1):
        q = arm.inverse(_between(start, goal, index / count), near=path[-1], restarts=0)
        if q is None or float(np.abs(q - path[-1]).max()) > _LEAP:
            return None
        path.append(q)
    line = np.array(path)
    return line if collision is None or collision.path_free(line) else None


_LineCheck = Callable[[FloatArray, FloatArray], bool]
_LEAP = 0.2  # [rad] between two poses a step apart
_RANGE = 0.6  # [rad] longest branch of the trees
_SHORTCUTS = 80


def _longer_ways(arm: ArmModel, q_start: FloatArray, q_goal: FloatArray) -> Iterator[FloatArray]:
    """Yield the goal posture (n,) with one continuous joint at a time turned the longer way."""
    for joint in np.flatnonzero(arm.endless):
        goal = np.array(q_goal, dtype=np.float64)
        goal[joint] -= np.copysign(2.0 * np.pi, goal[joint] - q_start[joint])
        yield goal


def _between(start: pin.SE3, goal: pin.SE3, share: float) -> Transform:
    """Return the pose at a share of the straight line, and of the shortest turn, between two poses."""
    turn = pin.exp3(share * pin.log3(start.rotation.T @ goal.rotation))
    result = np.eye(4)
    result[:3, :3] = start.rotation @ turn
    result[:3, 3] = (1.0 - share) * start.translation + share * goal.translation
    return result


class _Lines(ob.MotionValidator):  # type: ignore[misc]  # ompl ships no types
    """OMPL's check of straight lines, by the same function that the result must pass."""

    def __init__(
        self, information: ob.SpaceInformation, collision: CollisionModel, dof: int, step: float
    ) -> None:
        super().__init__(information)
        self._collision = collision
        self._dof = dof
        self._step = step
        self.tried = 0

    def checkMotion(self, first: ob.State, second: ob.State) -> bool:
        self.tried += 1
        a, b = _angles(first, self._dof), _angles(second, self._dof)
        return self._collision.line_free(a, b, self._step)


def _rrt_connect(
    arm: ArmModel,
    collision: CollisionModel,
    q_start: FloatArray,
    q_goal: FloatArray,
    seed: int,
    max_branches: int,
    step: float,
) -> FloatArray | None:
    # OMPL seeds its generators from a global one. Seed that first, and make space and planner again, so that
    # each call has its own stream. OMPL warns about it in its log, which is switched off here.
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    ou.RNG.setSeed(1 + seed % (2**31 - 1))
    information = ob.SpaceInformation(_space(arm, q_start, q_goal))
    information.setStateValidityChecker(lambda state: not collision.in_collision(_angles(state, arm.dof)))
    lines = _Lines(information, collision, arm.dof, step)
    information.setMotionValidator(lines)
    information.setup()
    problem = ob.ProblemDefinition(information)
    problem.setStartAndGoalStates(_state(information, q_start), _state(information, q_goal))
    planner = og.RRTConnect(information)
    planner.setRange(_RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(ob.PlannerTerminationCondition(lambda: lines.tried >= max_branches))
    if not problem.hasExactSolution():
        return None
    states = problem.getSolutionPath()
    return np.array([_angles(states.getState(index), arm.dof) for index in range(states.getStateCount())])


def _space(arm: ArmModel, q_start: FloatArray, q_goal: FloatArray) -> ob.RealVectorStateSpace:
    """Return the joint limits; of continuous joints the turns about both ends."""
    around = np.array([q_start, q_goal])
    lower = np.where(arm.endless, around.min(axis=0) - np.pi, arm.lower)
    upper = np.where(arm.endless, around.max(axis=0) + np.pi, arm.upper)
    bounds = ob.RealVectorBounds(arm.dof)
    for index in range(arm.dof):
        bounds.setLow(index, float(lower[index]))
        bounds.setHigh(index, float(upper[index]))
    space = ob.RealVectorStateSpace(arm.dof)
    space.setBounds(bounds)
    return space


def _state(information: ob.SpaceInformation, q: FloatArray) -> ob.State:
    state = information.allocState()
    for index, angle in enumerate(q):
        state[index] = float(angle)
    return state


def _angles(state: ob.State, dof: int) -> FloatArray:
    return np.array([state[index] for index in range(dof)])


def _remembering(collision: CollisionModel, step: float) -> _LineCheck:
    """Return a function that reports whether the line between two postures is free, and checks it once."""
    known: dict[tuple[bytes, bytes], bool] = {}

    def free(a: FloatArray, b: FloatArray) -> bool:
        line = a.tobytes(), b.tobytes()
        if line not in known:
            known[line] = collision.line_free(a, b, step)
        return known[line]

    return free


def _shorten(path: FloatArray, free: _LineCheck, seed: int) -> FloatArray:
    """Replace pieces between two random points of the path by straight lines where these are free.

    What remains of a cut line was checked as a part of it, with samples elsewhere. It is checked again in the
    end only. If it is not free there, pieces are replaced again, and it is checked at each cut.
    """
    shorter = _with_shortcuts(path, free, np.random.default_rng(seed), rests=False)
    if all(free(p, q) for p, q in pairwise(shorter)):
        return shorter
    return _with_shortcuts(path, free, np.random.default_rng(seed), rests=True)


def _with_shortcuts(path: FloatArray, free: _LineCheck, rng: np.random.Generator, rests: bool) -> FloatArray:
    """Return the path (m, n) with free shortcuts; `rests`: True to check the remains of cut lines too."""
    path = _without_detours(path, free)
    lengths = _lengths(path)
    for _ in range(_SHORTCUTS):
        if len(path) == 2:
            break
        first, second = np.sort(rng.uniform(0.0, lengths[-1], 2))
        a, b = (np.array([np.interp(s, lengths, column) for column in path.T]) for s in (first, second))
        before = path[: int(np.searchsorted(lengths, first, side="right"))]
        after = path[int(np.searchsorted(lengths, second, side="left")) :]
        if len(before) + len(after) >= len(path) or not free(a, b):
            continue
        shortcut = _merged(np.vstack((before[-1:], a, b, after[:1])))
        if not rests or all(free(p, q) for p, q in pairwise(shortcut)):
            path = np.vstack((before, shortcut[1:], after[1:]))
            lengths = _lengths(path)
    return _without_detours(path, free)


def _lengths(path: FloatArray) -> FloatArray:
    """Return the length (m,) of a path (m, n) up to each of its points, in [rad] or [m]."""
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))


def _without_detours(path: FloatArray, free: _LineCheck) -> FloatArray:
    """Replace stretches of a path (m, n) by free lines, from each point to the furthest one that a free line
    reaches.
    """
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        further = range(len(path) - 1, here + 1, -1)
        kept.append(next((there for there in further if free(path[here], path[there])), here + 1))
    return path[kept]


def _merged(path: FloatArray) -> FloatArray:
    """Return the path (m, n) without points that repeat the one before."""
    moved = np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-9
    return path[np.concatenate(([True], moved))]
