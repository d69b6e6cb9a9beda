"""A total station: it follows a reflector on the robot's hand, as in the field test of Ohki et al. (2012)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from handcart.backends.simulation.field.spec import StationSpec
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray

REFLECTOR_HEIGHT_M = 0.06  # [m] above the frame `hand`


class Sight(NamedTuple):
    """Reading of a total station: time and position of the reflector."""

    time: float
    """Time of the reading, in [s]."""
    place: FloatArray
    """Position (3,) of the reflector in the field's frame, in [m]."""


class TotalStation:
    """Total station that measures a reflector on the robot's hand by the ground truth, for evaluation only.

    It measures the reflector every `period_s` seconds of its spec, unless body or mast of the robot, or an
    object in the field, is in between. The reflector is directly above the held sensor, so that a tilt of the
    robot's vertical slide does not count as an error.
    """

    def __init__(self, spec: StationSpec, scene: Any, seed: int) -> None:
        """Place the station of `spec` in the field of a simulated scene; `seed` is that of its errors."""
        self._spec, self._scene, self._seed = spec, scene, seed
        self._place = np.array([spec.x_m, spec.y_m, spec.height_m])
        shapes = scene.arm.link_shapes(scene.joints)
        self._body = _Boxes.of([shape for shape in shapes if isinstance(shape, Box) and shape.name == "base"])
        solids = [solid.box for solid in scene.solids if solid.box.pose[2, 3] > 0.0]
        self._solids = _Boxes.of(solids)
        self._count = self._due()
        self.sights: list[Sight] = []
        """All readings so far, in the order of time."""
        self.hidden = 0
        """Number of readings at which the reflector was hidden."""

    def look(self) -> None:
        """Measure the reflector on the robot's hand if a measurement is due; called once a period."""
        if (count := self._due()) <= self._count:
            return
        self._count = count
        hand = self._scene.world_T("hand")
        reflector = hand[:3, 3] - REFLECTOR_HEIGHT_M * hand[:3, 0]
        if self._hidden(reflector):
            self.hidden += 1
            return
        noise = keyed(self._seed, "total station", self._count).standard_normal(3)
        self.sights.append(Sight(self._scene.time, reflector + self.sigma * noise))

    def _due(self) -> int:
        """Return the number of readings that a station has taken by now."""
        return int(self._scene.time / self._spec.period_s + 1e-6)

    @property
    def sigma(self) -> float:
        """Standard deviation of a measured position along each axis, in [m]."""
        return self._spec.accuracy_mm / 2e3

    def _hidden(self, reflector: FloatArray) -> bool:
        base = inverse(self._scene.world_T_base)
        place, there = (base[:3, :3] @ point + base[:3, 3] for point in (self._place, reflector))
        return _cut(self._body, place, there) or _cut(self._solids, self._place, reflector)


class _Boxes(NamedTuple):
    """Boxes that may be between the total station and the reflector."""

    poses: FloatArray
    """Poses (n, 4, 4) of the boxes in the world."""
    halves: FloatArray
    """Half sizes (n, 3) of the boxes, in [m]."""

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> _Boxes:
        """Return the boxes as arrays."""
        poses = np.array([box.pose for box in boxes]).reshape(-1, 4, 4)
        return cls(poses, np.array([box.size for box in boxes]).reshape(-1, 3) / 2)


def _cut(boxes: _Boxes, start: FloatArray, end: FloatArray) -> bool:
    """Return whether the line between two points (3,) in the world, in [m], passes through any box (slab
    method).
    """
    turns, middles = boxes.poses[:, :3, :3], boxes.poses[:, :3, 3]
    here, ray = np.einsum("ni,nij->nj", start - middles, turns), (end - start) @ turns
    ray = np.where(np.abs(ray) < 1e-12, 1e-12, ray)
    first, second = (-boxes.halves - here) / ray, (boxes.halves - here) / ray
    enters, leaves = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    return bool((np.maximum(enters, 0.0) < np.minimum(leaves, 1.0)).any())
