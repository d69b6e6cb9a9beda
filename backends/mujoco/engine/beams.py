"""Free lengths of lidar beams in MuJoCo's world."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.geometry.boxes_ahead import boxes_ahead
from handcart.robotics.geometry.ground_ahead import ground_ahead
from handcart.robotics.numerics.arrays import FloatArray

from .mujoco_module import mujoco
from .world_spec import ROBOT_GROUP

_FAR = 1e10  # [m], beyond any real range: MuJoCo ignores what is farther


class _Field(NamedTuple):
    """Height field of rough ground on the world's axes.

    Fields: `corner` (2,) with the least x and y in [m], `cell` distance of neighbouring heights in [m],
    `heights` (rows, columns) in [m] with a row for each y, `top` the largest height in [m].
    """

    corner: FloatArray
    cell: float
    heights: FloatArray
    top: float

    @classmethod
    def of(cls, model: Any, geometry: int) -> _Field:
        number = int(model.geom_dataid[geometry])
        rows, columns = int(model.hfield_nrow[number]), int(model.hfield_ncol[number])
        half_x, half_y, span, _ = model.hfield_size[number]
        first = int(model.hfield_adr[number])
        raw = model.hfield_data[first : first + rows * columns].reshape(rows, columns)
        x, y, low = model.geom_pos[geometry]
        heights = np.ascontiguousarray(low + span * raw.astype(np.float64))
        return cls(
            np.array([x - half_x, y - half_y]), 2 * half_x / (columns - 1), heights, float(heights.max())
        )


class LidarBeams:
    """Ray casting for a lidar in a compiled MuJoCo model; the robot's own parts are ignored.

    MuJoCo's `mj_multiRay` tests each body for each beam, which in a world of many bodies takes as long as
    eight steps of the solver; with rough ground it takes as long as fifty. This class tests only the ground
    and the boxes at the beams' height. If other shapes are at that height, for example a wedge, it calls
    MuJoCo.
    """

    def __init__(self, model: Any) -> None:
        """Prepare the beams of a compiled model."""
        self._model, kinds = model, mujoco().mjtGeom
        seen = model.geom_group != ROBOT_GROUP
        self._planes = np.flatnonzero(seen & (model.geom_type == kinds.mjGEOM_PLANE))
        self._others = np.flatnonzero(seen & (model.geom_type != kinds.mjGEOM_PLANE))
        self._boxes = model.geom_type[self._others] == kinds.mjGEOM_BOX
        self._grounds = model.geom_type[self._others] == kinds.mjGEOM_HFIELD
        self._reach = model.geom_rbound[self._others, None]
        self._fields = {int(item): _Field.of(model, int(item)) for item in self._others[self._grounds]}

    def free_shares(self, data: Any, start: FloatArray, ends: FloatArray) -> FloatArray:
        """Return the free share of each line from a start to an end, ignoring the robot.

        Args:
            data: MuJoCo's data, with the current poses.
            start: (3,) common start of the lines in the world, in [m].
            ends: (n, 3) ends of the lines in the world, in [m].

        Returns:
            (n,) distance from the start to the first body divided by the line's length, 0 to 1; infinity if
            all of a line is free.
        """
        middles = data.geom_xpos[self._others]
        low, high = np.minimum(ends.min(axis=0), start), np.maximum(ends.max(axis=0), start)
        near = ((middles + self._reach >= low) & (middles - self._reach <= high)).all(axis=1)
        if not (self._boxes | self._grounds)[near].all():
            return self._asked(data, start, ends)
        start, ways = np.ascontiguousarray(start), np.ascontiguousarray(ends - start)
        boxes = self._others[near & self._boxes]
        turns, halves = data.geom_xmat[boxes].reshape(-1, 3, 3), self._model.geom_size[boxes]
        shares = boxes_ahead(start, ways, data.geom_xpos[boxes], turns, halves)
        for ground in self._others[near & self._grounds].tolist():
            shares = np.minimum(shares, ground_ahead(start, ways, *self._fields[ground]))
        for plane in self._planes:
            up = data.geom_xmat[plane, 2::3]
            above, sinks = float((start - data.geom_xpos[plane]) @ up), -(ways @ up)
            if above >= 0.0 and sinks.max() >= above:
                met = sinks >= max(above, 1e-12)
                shares[met] = np.minimum(shares[met], above / sinks[met])
        return shares

    def _asked(self, data: Any, start: FloatArray, ends: FloatArray) -> FloatArray:
        """Return the same shares (n,) as `free_shares`, computed by MuJoCo itself."""
        ways = np.ascontiguousarray(ends - start)
        met, share = np.full(len(ways), -1, np.int32), np.zeros(len(ways))
        groups = np.ones(6, np.uint8)
        groups[ROBOT_GROUP] = 0
        mujoco().mj_multiRay(
            self._model, data, start, ways.ravel(), groups, True, -1, met, share, None, len(ways), _FAR
        )
        return np.where((met >= 0) & (share <= 1.0), share, np.inf)
