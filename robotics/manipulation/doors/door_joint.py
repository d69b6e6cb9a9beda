"""Motion of a door or a drawer with one joint."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.numerics.arrays import FloatArray


class DoorJoint(NamedTuple):
    """Model of how a door moves, by a hinge with a vertical axis or by a level slide.

    The frame of a handle has its origin in the middle of the handle's bar, x away from the closed door
    towards somebody in front of it, and z up.
    """

    closed: Transform
    """Pose (4, 4) of the handle with the door closed, in any frame with z up, the frame of `closed`."""
    hinge: tuple[float, float] | None
    """x and y of the hinge in the frame of the closed door's handle, in [m]; None for a slide."""
    sign: float
    """Sign (1 or -1) of the handle's turn about z, or of its motion along x, when the door opens."""

    @property
    def radius(self) -> float:
        """Distance from the hinge to the handle, in [m]; infinity for a slide."""
        return math.inf if self.hinge is None else math.hypot(*self.hinge)

    def with_handle(self, handle: Transform, opening: float) -> DoorJoint:
        """Return this joint, moved so that its handle is at a measured pose.

        Args:
            handle: (4, 4) pose of the handle, in any frame; the joint returned is in that frame.
            opening: opening of the door when its handle is at this pose, in [rad], or in [m] for a slide.
        """
        return self._replace(closed=np.asarray(handle @ inverse(self._moved(opening))))

    def _moved(self, opening: float) -> Transform:
        """Return the pose (4, 4) of the open door's handle in the frame of the closed one."""
        if self.hinge is None:
            return transform((self.sign * opening, 0.0, 0.0))
        there = transform((*self.hinge, 0.0))
        return np.asarray(there @ transform(rpy=(0.0, 0.0, self.sign * opening)) @ inverse(there))

    def displaced(self, opening: float) -> Transform:
        """Return the motion (4, 4) of the door from closed to an opening, in [rad] or [m].

        For any part of the door, motion @ (pose with the door closed) is the pose at the opening. All are in
        the frame of the attribute `closed` (pose of the closed door's handle).
        """
        return np.asarray(self.closed @ self._moved(opening) @ inverse(self.closed))

    def handle_at(self, opening: float) -> Transform:
        """Return the handle's pose (4, 4) when the door is open by `opening`, in [rad] or [m].

        The pose is in the frame of the attribute `closed` (pose of the closed door's handle).
        """
        return np.asarray(self.displaced(opening) @ self.closed)

    def opening_at(self, point: FloatArray) -> float:
        """Return the opening, in [rad] or [m], at which the handle is nearest to a point.

        Args:
            point: (3,) in [m], in the frame of the attribute `closed` (pose of the closed door's handle).
        """
        x, y, _ = (inverse(self.closed) @ np.append(point, 1.0))[:3].tolist()
        if self.hinge is None:
            return float(self.sign * x)
        hx, hy = self.hinge
        turn = math.atan2(y - hy, x - hx) - math.atan2(-hy, -hx)
        return self.sign * math.remainder(turn, 2.0 * math.pi)

    def travel(self, opening: float) -> float:
        """Return the length, in [m], of the handle's path from the closed door to an opening in [rad]
        or [m].
        """
        return opening if self.hinge is None else opening * self.radius

    def heading(self, opening: float) -> float:
        """Return the direction in which the handle moves while the door opens further, in [rad].

        The angle is about z, and 0 along x, of the frame in which the attribute `closed` (pose of the closed
        door's handle) is given. `opening` is in [rad], or in [m] for a slide.
        """
        step = self.handle_at(opening + 1e-6)[:3, 3] - self.handle_at(opening)[:3, 3]
        return math.atan2(step[1], step[0])

    def opening_of(self, handle: Transform) -> float:
        """Return how far the door is open if its handle is at a pose: in [rad], or in [m] for a slide.

        For a hinge, the opening is computed from the handle's orientation, for a slide from its position.

        Args:
            handle: (4, 4) pose of the handle, in the frame of the attribute `closed` (pose of the closed
                door's handle).
        """
        if self.hinge is None:
            return self.opening_at(handle[:3, 3])
        turn = math.atan2(handle[1, 0], handle[0, 0]) - math.atan2(self.closed[1, 0], self.closed[0, 0])
        return self.sign * math.remainder(turn, 2.0 * math.pi)

    def curvature(self) -> float:
        """Return the signed curvature of the handle's path, in [1/m]: positive if the path bends to the left
        as the door opens, 0 for a slide.
        """
        return 0.0 if self.hinge is None else self.sign / self.radius
