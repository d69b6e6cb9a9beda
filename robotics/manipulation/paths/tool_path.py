"""A path of tool poses, with tangent, turn and arc length at each point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from handcart.robotics.numerics.arrays import FloatArray

from .untrackable import Untrackable

LONGEST_STEP = 0.05  # [m] between points of a path; more is a jump
LONGEST_TURN = 0.2  # [rad]
_RIGID = 1e-6
_NO_LENGTH = 1e-300
_NOT_FINITE = "has a number that isn't finite"
_NO_ROTATION = "has a rotation that is none"


class ToolPath(NamedTuple):
    """Path of a tool, given by p of its poses in the frame world; the tool points along the x axis of its
    frame.
    """

    points: FloatArray
    """(p, 3), in [m]."""
    rotations: FloatArray
    """(p, 3, 3): world_R_tool."""
    tangents: FloatArray
    """(p, 3) unit vectors along the path, in world."""
    turns: FloatArray
    """(p, 3): turn of the tool for each metre of path, about the axes of world, in [rad/m]."""
    lengths: FloatArray
    """(p,): arc length from the first point, in [m]."""

    @property
    def length(self) -> float:
        """Arc length of the complete path, in [m]."""
        return float(self.lengths[-1])

    @property
    def twists(self) -> FloatArray:
        """Return the motion (p, 6) of the tool for each metre of path, in the world, [m/m] and then [rad/m].

        Shin (2005) instead joins the unit vectors of translation and of rotation (below eq. 3). That mixes
        units, and is undefined on a seam along which the tool doesn't turn.
        """
        return np.hstack((self.tangents, self.turns))

    @property
    def poses(self) -> FloatArray:
        """Return the poses world_T_tool (p, 4, 4), in [m]."""
        poses = np.tile(np.eye(4), (len(self.points), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = self.rotations, self.points
        return poses

    def part(self, first: int, last: int) -> ToolPath:
        """Return the part of the path from point `first` to point `last`, both included; arc length starts at
        zero again.
        """
        cut = ToolPath(*(field[first : last + 1] for field in self))
        return cut._replace(lengths=cut.lengths - cut.lengths[0])

    def at(self, lengths: FloatArray) -> ToolPath:
        """Return the path with other points, interpolated on straight lines between its present points.

        Args:
            lengths: (k,) arc lengths of the new points from the path's start, in [m].
        """
        points, tangents, turns = (
            np.column_stack([np.interp(lengths, self.lengths, axis) for axis in field.T])
            for field in (self.points, self.tangents, self.turns)
        )
        rotations = Slerp(self.lengths, Rotation.from_matrix(self.rotations))(lengths).as_matrix()
        return ToolPath(points, rotations, tangents, turns, lengths)


def tool_path(
    poses: FloatArray | Sequence[FloatArray],
    longest_step: float = LONGEST_STEP,
    longest_turn: float = LONGEST_TURN,
) -> ToolPath:
    """Return the path of a tool through poses in the world frame.

    Args:
        poses: (p, 4, 4) world_T_tool.
        longest_step: maximum distance between consecutive points, in [m].
        longest_turn: maximum turn between consecutive points, in [rad].

    Raises:
        Untrackable: a point has a NaN, is not a pose, repeats the point before, or is farther from it than
            the maximum; names the first such point.
        ValueError: fewer than two poses.
    """
    poses = np.asarray(poses, dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or len(poses) < 2:
        raise ValueError(f"a path has at least two poses (4, 4); this one has shape {poses.shape}")
    _check(poses, longest_step, longest_turn)
    points, rotations = poses[:, :3, 3], poses[:, :3, :3]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    lengths = np.concatenate(([0.0], np.cumsum(steps)))
    tangents = _tangents(points, steps)
    turns = _turns(rotations) / steps[:, None]
    outer = np.vstack((turns[:1], turns, turns[-1:]))
    return ToolPath(points, rotations, tangents, 0.5 * (outer[:-1] + outer[1:]), lengths)


def _tangents(points: FloatArray, steps: FloatArray) -> FloatArray:
    """Return the unit derivatives (p, 3) by arc length, of the parabolas through three points each."""
    slopes = np.diff(points, axis=0) / steps[:, None]
    if len(slopes) == 1:
        return np.vstack((slopes, slopes))
    before, after = steps[:-1, None], steps[1:, None]
    inner = (after * slopes[:-1] + before * slopes[1:]) / (before + after)
    tangents = np.vstack((2.0 * slopes[:1] - inner[:1], inner, 2.0 * slopes[-1:] - inner[-1:]))
    return np.asarray(tangents / np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), _NO_LENGTH))


def _check(poses: FloatArray, longest_step: float, longest_turn: float) -> None:
    rotations = poses[:, :3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        finite = np.asarray(np.isfinite(poses).all(axis=(1, 2)))
        strain = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        skewed = finite & np.logical_not((strain < _RIGID) & (np.linalg.det(rotations) > 0.0))
        steps = np.concatenate(([0.0], np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)))
    bad = np.flatnonzero(~finite | skewed)
    sound = int(bad[0]) if len(bad) else len(poses)
    _check_steps(steps[:sound], rotations[:sound], longest_step, longest_turn)
    if len(bad):
        raise Untrackable(sound, _NO_ROTATION if finite[sound] else _NOT_FINITE)


def _check_steps(steps: FloatArray, rotations: FloatArray, longest_step: float, longest_turn: float) -> None:
    """Raise `Untrackable` if a step repeats a point or jumps; covers the points before the first invalid
    pose.
    """
    turned = np.zeros(len(steps))
    if len(steps) > 1:
        turned[1:] = np.linalg.norm(_turns(rotations), axis=1)
    for index in range(1, len(steps)):
        if steps[index] == 0.0:
            raise Untrackable(index, "repeats the position before it")
        if steps[index] > longest_step:
            raise Untrackable(index, f"jumps by {steps[index]:.3f} m; allowed: {longest_step:g} m a step")
        if turned[index] > longest_turn:
            why = f"turns the tool by {turned[index]:.3f} rad; allowed: {longest_turn:g} rad a step"
            raise Untrackable(index, why)


def _turns(rotations: FloatArray) -> FloatArray:
    """Return the rotation vectors (p-1, 3) from each orientation to the next, in world."""
    return np.asarray(Rotation.from_matrix(rotations[1:] @ rotations[:-1].transpose(0, 2, 1)).as_rotvec())
