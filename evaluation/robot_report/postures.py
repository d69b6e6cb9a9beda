"""Finding a posture that has the hand at some place, pointing some way."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pointing import VERTICAL, pointing
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

from .masses import corners_of
from .self_contact import Pair

STARTS = 60
FEWER_STARTS = 20  # for each of several rolls
ROLLS = 12  # that are tried where any will do
MARGIN = 0.008  # [m] between the arm's own links

Vector = NDArray[np.float64]


class HandAim(NamedTuple):
    """Where the hand is to be, in the base frame, and which way it is to point."""

    place: tuple[float, float, float]
    """[m]"""
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    """Of its x axis."""
    roll_deg: float | None = None
    """About that; None: upright, or any where it points up or down."""

    def poses(self) -> Iterator[Transform]:
        """Yield base_T_hand (4, 4) for each roll that will do."""
        x, y, z = self.direction
        is_vertical = abs(z) > VERTICAL * math.sqrt(x * x + y * y + z * z)
        rolls = [self.roll_deg or 0.0]
        if self.roll_deg is None and is_vertical:
            rolls = [360.0 * number / ROLLS for number in range(ROLLS)]
        for roll in rolls:
            yield transform(self.place) @ pointing(self.direction, math.radians(roll))


class PostureSearch(NamedTuple):
    """What came of a search for a posture."""

    angles: list[float] | None
    """[deg], or [mm] for joints that slide; None: no free posture was found."""
    reached: int
    """Postures that have the hand there."""
    touching: Sequence[tuple[Pair, float]]
    """Pairs of links that touch in these, with the share of postures, the most frequent first."""


def posture_at(robot: RobotFile, aim: HandAim) -> PostureSearch:
    """Search a posture that has the hand somewhere, the arm free of itself and of the robot.

    Of several such postures the one most like `home` is taken; where that isn't known, the one that keeps
    closest to the base's axis.

    Raises:
        ValueError: the robot has no arm, or the direction no length.
    """
    arm = robot.arm_model()
    free = CollisionModel(arm, margin=MARGIN)
    found = list(_reaching(arm, list(aim.poses())))
    good = [q for q in found if not free.in_collision(q)]
    if not good:
        return PostureSearch(None, len(found), _touching(free, found))
    assert robot.arm is not None
    home = np.array(robot.posture("home")) if "home" in robot.arm.postures else None
    best = min(good, key=lambda q: _extent(arm, q) if home is None else float(np.abs(q - home).max()))
    return PostureSearch(list(robot.joint_units.user_units(best.tolist())), len(found), ())


def _reaching(arm: ArmModel, poses: Sequence[Transform]) -> Iterator[Vector]:
    """Postures that have the hand at one of some poses, by descents from random ones."""
    count = STARTS if len(poses) == 1 else FEWER_STARTS
    starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (count, arm.dof))
    starts[: count // 2] *= 0.5
    for pose in poses:
        arrived = (arm.inverse(pose, start, restarts=0) for start in starts)
        yield from (q for q in arrived if q is not None)


def _touching(model: CollisionModel, postures: Sequence[Vector]) -> list[tuple[Pair, float]]:
    pairs = Counter((min(pair), max(pair)) for q in postures for pair in set(model.contacts(q)))
    return [(pair, count / len(postures)) for pair, count in pairs.most_common()]


def _extent(arm: ArmModel, q: Vector) -> float:
    """How far from the base's axis anything of the robot reaches, in [m]; of equals the least bent one."""
    out = max((float(np.hypot(*corners_of(each)[:, :2].T).max()) for each in arm.link_shapes(q)), default=0.0)
    return round(out, 2) + 1e-3 * float(np.abs(q).max())
