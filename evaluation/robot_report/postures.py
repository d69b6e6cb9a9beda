"""Finding a posture that has the hand at some place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

from .masses import corners_of

STARTS = 60
MARGIN = 0.008  # [m] between the arm's own links


def posture_at(robot: RobotFile, place: tuple[float, float, float]) -> list[float] | None:
    """A posture that has the hand at a place of the base frame in [m], upright, pointing ahead.

    It is given in [deg], in [mm] for joints that slide. The arm doesn't touch itself or the robot. Of several
    such postures the one most like `home` is taken; where that isn't known, the one that keeps closest to
    the base's axis. None where there is none.

    Raises:
        ValueError: the robot has no arm.
    """
    arm = robot.arm_model()
    free = CollisionModel(arm, margin=MARGIN)
    starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (STARTS, arm.dof))
    starts[: STARTS // 2] *= 0.5
    found = [arm.inverse(transform(place), start, restarts=0) for start in starts]
    good = [q for q in found if q is not None and not free.in_collision(q)]
    if not good:
        return None
    assert robot.arm is not None
    home = np.array(robot.posture("home")) if "home" in robot.arm.postures else None
    best = min(good, key=lambda q: _extent(arm, q) if home is None else float(np.abs(q - home).max()))
    return list(robot.joint_units.user_units(best.tolist()))


def _extent(arm: ArmModel, q: NDArray[np.float64]) -> float:
    """How far from the base's axis anything of the robot reaches, in [m]; of equals the least bent one."""
    out = max(float(np.hypot(*corners_of(shape)[:, :2].T).max()) for shape in arm.link_shapes(q))
    return round(out, 2) + 1e-3 * float(np.abs(q).max())
