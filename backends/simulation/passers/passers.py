"""All passers of a simulated world: where they truly are, and what a lidar sees of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

from .passer_spec import PasserSpec
from .walk import Walk, WalkStep

BODY_HEIGHT_M = 1.7
LEG_HEIGHT_M = 0.85  # above which a lidar sees the body instead of the legs
LEG_RADIUS_M = 0.07
LEG_OFFSET_M = 0.10  # of each leg to its side
LEG_SWING_M = 0.20  # of each leg along the walk, at most
STEP_LENGTH_M = 0.7  # from one foot to the other
PASSER_GREY = 90
FAR_M = 1e6
BRUSHING_M = 0.01  # by which a body that walks into the robot overlaps it
YIELD_ANGLE_COS = 0.3  # of the direction to the robot, from which the robot counts as ahead


class PasserPart(NamedTuple):
    """Upright cylinder that models a leg, the trunk or the body of a passer."""

    name: str
    """Name of the passer."""
    x: float
    y: float
    radius: float
    """Radius of the disc, in [m]; `x` and `y` are its middle in the world, in [m]."""
    low: float
    """Height of the disc's underside above the floor, in [m]; `high` is that of its top."""
    high: float


class PasserShape:
    """Box that represents a passer (a walking person or cart) in camera pictures."""

    grey = PASSER_GREY

    def __init__(self, name: str, radius: float, pose: Transform) -> None:
        """Describe the box of a passer.

        Args:
            name: name of the passer.
            radius: radius of the body, in [m].
            pose: world_T_passer (4, 4), at the passer's feet.
        """
        self.name, self.pose = name, pose
        self.size = (1.6 * radius, 2.0 * radius, BODY_HEIGHT_M)
        self.thing_T_middle = np.eye(4)
        self.thing_T_middle[2, 3] = BODY_HEIGHT_M / 2


class Passers:
    """People and carts that walk through a simulated world, in groups that walk and pause together."""

    STATE: ClassVar[Kinds] = {"clocks": FloatArray, "robot": tuple[float, float, float]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, specs: Sequence[PasserSpec] = (), seed: int = 0) -> None:
        """Put all passers at their first waypoints; `seed` draws the speeds."""
        self._specs = tuple(specs)
        self.clocks = np.zeros(len(specs))
        """Times (n,) that each group has walked or paused, in [s]."""
        self.robot = (FAR_M, FAR_M, 0.0)
        """x and y in the world and radius of the robot, which passers do not walk through, in [m]; far off at
        first.
        """
        self._walks: list[tuple[int, str, Walk]] = []
        for number, spec in enumerate(specs):
            drawn = float(keyed(seed, "passer", number).standard_normal(1)[0])
            factor = 1.0 + spec.speed_sigma_percent / 100.0 * max(-3.0, min(3.0, drawn))
            for name, offset in zip(spec.members, (0.0, *spec.group_m), strict=True):
                self._walks.append((number, name, Walk(spec, offset, factor * spec.speed_m_s)))

    def __bool__(self) -> bool:
        return bool(self._walks)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all passers (people or carts on the move), including each member of a group."""
        return tuple(name for _, name, _ in self._walks)

    def advance(self, time: float, period: float, base: Pose2, radius: float) -> None:
        """Let all passers walk for a period.

        Args:
            time: simulated time at the end of the period, in [s].
            period: length of the period, in [s].
            base: world_T_base, to which passers that yield react.
            radius: radius of the robot's footprint, in [m].
        """
        self.robot = base.x, base.y, radius
        for number, spec in enumerate(self._specs):
            if time - period >= spec.starts_s - 1e-9 and not (
                spec.yields and self._sees_robot(number, base, radius)
            ):
                self.clocks[number] += period

    def _sees_robot(self, number: int, base: Pose2, radius: float) -> bool:
        """Return whether the robot is near and ahead of any member of a group.

        Args:
            number: index of the group.
            base: world_T_base.
            radius: radius of the robot's footprint, in [m].
        """
        spec = self._specs[number]
        for step in (walk.at(self.clocks[number]) for owner, _, walk in self._walks if owner == number):
            ray = np.array([base.x, base.y]) - step.position
            away = float(np.hypot(*ray))
            is_near = away - radius - spec.radius_m < spec.yields_m
            if is_near and ray @ step.direction > YIELD_ANGLE_COS * away:
                return True
        return False

    def steps(self) -> list[tuple[str, float, WalkStep]]:
        """Return name, radius in [m], and present position and motion of each passer, a simulated person who
        walks about.
        """
        return [
            (name, self._specs[number].radius_m, self._step(number, walk))
            for number, name, walk in self._walks
        ]

    def _step(self, number: int, walk: Walk) -> WalkStep:
        """Return a walker's step; one whose way leads through the robot brushes along its side."""
        step, (x, y, radius) = walk.at(float(self.clocks[number])), self.robot
        off, size = step.position - (x, y), radius + self._specs[number].radius_m - BRUSHING_M
        if not float(np.hypot(*off)) < size:
            return step
        left = np.array([-step.direction[1], step.direction[0]])
        along, aside = float(off @ step.direction), float(off @ left)
        aside = math.copysign(math.sqrt(size**2 - along**2), aside)
        return step._replace(position=np.array([x, y]) + along * step.direction + aside * left)

    def parts(self) -> list[PasserPart]:
        """Return the bodies of all passers: legs and trunk, or a single upright cylinder."""
        found: list[PasserPart] = []
        for number, name, walk in self._walks:
            spec, step = self._specs[number], self._step(number, walk)
            x, y = step.position.tolist()
            legs = spec.body == "legs"
            if legs:
                found += [PasserPart(name, *leg, LEG_RADIUS_M, 0.0, LEG_HEIGHT_M) for leg in _legs(step)]
            low = LEG_HEIGHT_M if legs else 0.0
            found.append(PasserPart(name, x, y, spec.radius_m, low, BODY_HEIGHT_M))
        return found

    def discs(self, height: float) -> FloatArray:
        """Return the parts of passers that a level lidar sees: discs (n, 3), x, y in the world and radius, in
        [m].

        Args:
            height: height of the lidar's plane above the floor, in [m].
        """
        if not self._walks:
            return np.empty((0, 3))
        rows = [(part.x, part.y, part.radius) for part in self.parts() if part.low <= height < part.high]
        return np.array(rows).reshape(-1, 3)

    def clearance(self, x: float, y: float) -> tuple[float, str]:
        """Return the distance of a point to the nearest passer's body in [m], and the passer's name.

        Below 0 the point is inside; infinity and "" without passers.

        Args:
            x: in the world, in [m].
            y: in the world, in [m].
        """
        nearest, whose = math.inf, ""
        for name, radius, step in self.steps():
            away = math.hypot(step.position[0] - x, step.position[1] - y) - radius
            if away < nearest:
                nearest, whose = away, name
        return nearest, whose

    def touched(self, base: Pose2, footprint: Footprint) -> list[str]:
        """Return the names of the passers who touch a footprint at world_T_base."""
        return [name for name, gap in self._gaps(base, footprint) if gap < 0.0]

    def gap(self, base: Pose2, footprint: Footprint) -> tuple[float, str]:
        """Return the distance of a footprint at world_T_base to the nearest passer's body in [m], and the
        passer's name.

        A negative distance means that they overlap. Without passers, the result is infinity and "".
        """
        gaps = ((gap, name) for name, gap in self._gaps(base, footprint))
        return min(gaps, default=(math.inf, ""))

    def _gaps(self, base: Pose2, footprint: Footprint) -> list[tuple[str, float]]:
        steps = self.steps()
        if not steps:
            return []
        middles = base.inverse().apply(np.array([step.position for _, _, step in steps]))
        away = footprint.distances(middles)
        return [(name, float(d) - size) for (name, size, _), d in zip(steps, away, strict=True)]

    def shapes(self) -> list[PasserShape]:
        """Return the boxes that represent all passers in camera pictures."""
        found = []
        for name, radius, step in self.steps():
            heading = math.atan2(step.direction[1], step.direction[0])
            pose = Pose2(float(step.position[0]), float(step.position[1]), heading).lift()
            found.append(PasserShape(name, radius, pose))
        return found


def _legs(step: WalkStep) -> list[tuple[float, float]]:
    """Return the middles of the left and the right leg on the floor, x and y in the world in [m]."""
    left = np.array([-step.direction[1], step.direction[0]])
    swing = LEG_SWING_M * math.sin(math.pi * step.walked / STEP_LENGTH_M) * step.direction
    middles = step.position + LEG_OFFSET_M * left + swing, step.position - LEG_OFFSET_M * left - swing
    return [(float(x), float(y)) for x, y in middles]
