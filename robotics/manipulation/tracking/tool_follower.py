"""Joint angles that keep a tool on a path, with the base at rest."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.arms.screw_arm import FreeTurn
from handcart.robotics.manipulation.arms.screw_chain import ChainPosture, ScrewChain
from handcart.robotics.manipulation.arms.screw_steps import descend, tip_and_jacobian, without_free
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import FloatArray

_ITERATIONS = 60
_JUMP = 0.5  # [rad] of a joint from a point to the next
_EASES = 0.02  # [rad] at most from a point to the next, by which spare joints keep away from their limits
_EAGER = 0.05  # of the way there
_SINGULAR = 1e-3
_LOCKED = 1e-9  # [rad]: half the range of a joint whose limits are equal


class ToolFollower:
    """Inverse kinematics of an arm along a path, in which the arm does not jump between its configurations.

    The search for each point starts at the joints of the point before.

    If a base did not stop at its planned pose, call `joints` with its measured pose and with the planned
    angles as `near`. The tool then follows the path as accurately as the base's pose was measured.

    A redundant arm also keeps away from its joint limits; a free turn of the tool makes an arm redundant.

    Args:
        arm: the arm; all its joints turn.
        free: the turn of the tool that the path leaves free.
        azimuth_tolerance: allowed turn of the tool about the vertical with FreeTurn.VERTICAL, in [rad].

    Raises:
        ValueError: a joint slides.
    """

    def __init__(
        self, arm: ArmModel, free: FreeTurn = FreeTurn.NONE, azimuth_tolerance: float = np.pi
    ) -> None:
        self.arm = arm
        self.free = free
        self.azimuth_tolerance = azimuth_tolerance
        self._chain = ScrewChain.of_arm(arm)
        self._spare = arm.dof > (6 if free == FreeTurn.NONE else 5)
        self._middle = 0.5 * (arm.lower + arm.upper)
        self._half = np.maximum(0.5 * (arm.upper - arm.lower), _LOCKED)  # of a joint that cannot move too

    def joints(self, path: ToolPath, world_T_base: Transform, near: FloatArray) -> FloatArray:
        """Return joint angles (p, n), in [rad], that put the tool at each point of the path, within the joint
        limits.

        Args:
            path: path of the tool.
            world_T_base: (4, 4) pose of the arm's base; it may be tilted.
            near: (n,) joint angles in [rad] at which the search for the first point begins.

        Raises:
            Untrackable: the first point that the arm doesn't reach, with the position of the tool at which
                the search ended; or the first point to which the arm would have to jump.
        """
        base_T_tools = inverse(world_T_base) @ path.poses
        angles = np.empty((len(base_T_tools), self.arm.dof))
        before = self.arm.clipped(near)
        for index, base_T_tool in enumerate(base_T_tools):
            angles[index] = self._step(base_T_tool, before, index, world_T_base)
            if index > 0 and np.abs(angles[index] - before).max() > _JUMP:
                raise Untrackable(index, "makes the arm jump to another of its ways to reach it")
            before = self._eased(angles[index]) if self._spare else angles[index]
        return angles

    def _step(
        self, base_T_tool: Transform, before: FloatArray, index: int, world_T_base: Transform
    ) -> FloatArray:
        posture, target = ChainPosture.at(before.copy()), np.ascontiguousarray(base_T_tool)
        q = posture.q
        if not descend(self._chain, target, int(self.free), _ITERATIONS, posture):
            nearest = (world_T_base @ self.arm.forward(q))[:3, 3]
            raise Untrackable(index, f"can't be reached{self._limit(q)}", nearest)
        if self.free == FreeTurn.VERTICAL and _azimuth(posture.pose, target) > self.azimuth_tolerance:
            raise Untrackable(index, "turns the tool's azimuth beyond the tolerance")
        return q

    def _eased(self, q: FloatArray) -> FloatArray:
        """Angles (n,) near by, with about the same pose of the tool, and further from the limits."""
        posture = ChainPosture.at(q)
        tip_and_jacobian(self._chain, posture)
        jacobian = posture.jacobian
        without_free(posture.pose, int(self.free), jacobian)
        # Weigh the share of a joint's range, most where little of it is left.
        share = np.where(self.arm.endless, 0.0, (q - self._middle) / self._half)
        wish = -_EAGER * share**3 * self._half
        ease = wish - np.linalg.pinv(jacobian, rcond=_SINGULAR) @ (jacobian @ wish)
        return np.asarray(q + ease * min(1.0, _EASES / max(1e-12, float(np.abs(ease).max()))))

    def _limit(self, q: FloatArray) -> str:
        """Return the names of the joints at their limits for messages."""
        held = ~self.arm.endless & (np.minimum(q - self.arm.lower, self.arm.upper - q) < 1e-6)
        names = [name for name, at_limit in zip(self.arm.joint_names, held, strict=True) if at_limit]
        return f": {', '.join(names)} at the limit" if names else ""


def _azimuth(pose: Transform, target: Transform) -> float:
    """Return the angle between the level parts of two tools' x axes, in [rad]."""
    across = target[0, 0] * pose[1, 0] - target[1, 0] * pose[0, 0]
    along = target[0, 0] * pose[0, 0] + target[1, 0] * pose[1, 0]
    return float(abs(np.arctan2(across, along)))
