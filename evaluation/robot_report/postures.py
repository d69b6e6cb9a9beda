"""Search of a posture with a given position and direction of the hand."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pointing import VERTICAL_COSINE, pointing
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

from .masses import corners_of
from .self_contact import Pair

START_COUNT = 60
FEWER_STARTS = 20  # for each of several rolls
ROLL_COUNT = 12  # rolls that are tried if any is allowed
LINK_MARGIN_M = 0.008  # between the arm's own links


class HandAim(NamedTuple):
    """Wanted position and direction of the hand in the base frame, as the goal of a posture search."""

    place: tuple[float, float, float]
    """Position, in [m]."""
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    """Direction of the hand's x axis."""
    roll_deg: float | None = None
    """Rotation about this direction; None: upright, or any if the direction is vertical."""

    def poses(self) -> Iterator[Transform]:
        """Yield base_T_hand (4, 4) for each allowed roll of the hand about the direction it points in."""
        x, y, z = self.direction
        is_vertical = abs(z) > VERTICAL_COSINE * math.sqrt(x * x + y * y + z * z)
        rolls = [self.roll_deg or 0.0]
        if self.roll_deg is None and is_vertical:
            rolls = [360.0 * number / ROLL_COUNT for number in range(ROLL_COUNT)]
        for roll in rolls:
            yield transform(self.place) @ pointing(self.direction, math.radians(roll))


class PostureSearch(NamedTuple):
    """Result of a search for an arm posture without collision at a wanted pose of the hand.

    If links touch in postures with that hand pose, the result names them.
    """

    angles: list[float] | None
    """Joint positions in [deg], or [mm] for prismatic joints; None: no collision-free posture was found."""
    reached: int
    """Number of found postures with the wanted hand pose, including those in collision."""
    touching: Sequence[tuple[Pair, float]]
    """Pairs of links that touch in these postures, with their share of the postures, the most frequent
    first.
    """


def posture_at(robot: RobotFile, aim: HandAim) -> PostureSearch:
    """Search a posture with the hand at the wanted pose and without collisions of the robot with itself.

    Among several postures it chooses the posture most similar to `home`; without `home`, the posture in which
    the arm stays closest to the base's axis.

    Raises:
        ValueError: the robot has no arm, or the direction in `aim` is a zero vector.
    """
    arm = robot.arm_model()
    free = CollisionModel(arm, margin=LINK_MARGIN_M)
    found = list(_reaching(arm, list(aim.poses())))
    good = [q for q in found if not free.in_collision(q)]
    if not good:
        return PostureSearch(None, len(found), _touching(free, found))
    assert robot.arm is not None
    home = np.array(robot.posture("home")) if "home" in robot.arm.postures else None
    best = min(good, key=lambda q: _extent(arm, q) if home is None else float(np.abs(q - home).max()))
    return PostureSearch(list(robot.joint_units.user_units(best.tolist())), len(found), ())


def _reaching(arm: ArmModel, poses: Sequence[Transform]) -> Iterator[FloatArray]:
    """Yield postures (n,), in [rad] or [m], with the hand at one of some poses, by inverse kinematics from
    random starts.
    """
    count = START_COUNT if len(poses) == 1 else FEWER_STARTS
    starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (count, arm.dof))
    starts[: count // 2] *= 0.5
    for pose in poses:
        arrived = (arm.inverse(pose, start, restarts=0) for start in starts)
        yield from (q for q in arrived if q is not None)


def _touching(model: CollisionModel, postures: Sequence[FloatArray]) -> list[tuple[Pair, float]]:
    pairs = Counter((min(pair), max(pair)) for q in postures for pair in set(model.contacts(q)))
    return [(pair, count / len(postures)) for pair, count in pairs.most_common()]


def _extent(arm: ArmModel, q: FloatArray) -> float:
    """Return the robot's largest distance from the base's axis at joints `q` (n,), in [m].

    A small penalty for bent joints is added.
    """
    out = max(
        (float(np.hypot(*corners_of(shape)[:, :2].T).max()) for shape in arm.link_shapes(q)), default=0.0
    )
    return round(out, 2) + 1e-3 * float(np.abs(q).max())
