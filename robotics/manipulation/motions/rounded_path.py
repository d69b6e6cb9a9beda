"""A polyline through joint space with its corners rounded, so that it can be passed without stopping."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


class RoundedPath:
    """Joint path of straight lines joined by circular arcs, as in Kunz and Stilman (2012), section IV.

    A point of the path is given by its arc length from the start, which is Euclidean over all joints.

    Args:
        corners: waypoints (m, n) in [rad] or [m], m at least 2, none repeating the one before, no reversal on
            the spot.
        deviation: largest distance of the rounded path from the polyline, in [rad] (Euclidean over joints).

    Attributes:
        knots: arc lengths at which a line or an arc begins, and the whole length last, (k+1,), in [rad].
    """

    def __init__(self, corners: FloatArray, deviation: float) -> None:
        steps = np.diff(corners, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        directions = steps / lengths[:, None]
        before, after = directions[:-1], directions[1:]
        # atan2 keeps the small angles of dense paths, where arccos of the dot product loses them.
        half = np.arctan2(np.linalg.norm(after - before, axis=1), np.linalg.norm(after + before, axis=1))
        # eq. 3 and 4: the cut off each line, at most half of it, and by the allowed deviation
        cut = np.minimum(0.5 * np.minimum(lengths[:-1], lengths[1:]), deviation / np.tan(0.5 * half + 1e-12))
        self._assemble(corners, directions, half, cut)

    @property
    def dof(self) -> int:
        """Number n of joints."""
        return int(self._start.shape[1])

    @property
    def length(self) -> float:
        """Arc length of the complete path over all joints, in [rad]; 1 m of a joint counts as 1 rad."""
        return float(self.knots[-1])

    def at(self, s: FloatArray, order: int = 0) -> FloatArray:
        """Return the joint angles at arc lengths, or their derivative by arc length.

        Where a line and an arc meet, the derivatives are those of the piece that begins there.

        Args:
            s: (k,) arc lengths, in [rad] over all joints; 1 m counts as 1 rad.
            order: 0 for the angles, 1 or 2 for a derivative.

        Returns:
            (k, n) in [rad] or [m]; derivatives in that unit per [rad] (order 1) or [rad²] (order 2).
        """
        index = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.knots) - 2)
        along = (s - self.knots[index])[:, None]
        bend = self._bend[index][:, None]
        x, y, start = self._x[index], self._y[index], self._start[index]
        phase = along * bend
        result: FloatArray
        if order == 0:
            ahead = np.where(bend > _STRAIGHT, np.sin(phase) / np.maximum(bend, _STRAIGHT), along)
            # 2 sin^2(x/2) for 1 - cos x: exact for the small turns of dense paths
            aside = np.where(
                bend > _STRAIGHT, 2.0 * np.sin(0.5 * phase) ** 2 / np.maximum(bend, _STRAIGHT), 0.0
            )
            result = start + ahead * x + aside * y
        elif order == 1:
            result = np.cos(phase) * x + np.sin(phase) * y
        else:
            result = bend * (np.cos(phase) * y - np.sin(phase) * x)
        return result

    def _assemble(
        self, corners: FloatArray, directions: FloatArray, half: FloatArray, cut: FloatArray
    ) -> None:
        """Assemble the pieces in order: line, arc, line, ..., line; skip pieces of length zero."""
        pieces: list[tuple[float, FloatArray, FloatArray, FloatArray, float]] = []
        trimmed_before = np.concatenate(([0.0], cut))
        trimmed_after = np.concatenate((cut, [0.0]))
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1) - trimmed_before - trimmed_after
        for index, direction in enumerate(directions):
            start = corners[index] + trimmed_before[index] * direction
            pieces.append((float(lengths[index]), start, direction, np.zeros_like(direction), 0.0))
            if index < len(cut) and cut[index] > 0.0:
                bend = float(np.tan(half[index]) / cut[index])
                turned = directions[index + 1] - directions[index]
                aside = turned - (turned @ direction) * direction
                aside /= max(float(np.linalg.norm(aside)), 1e-300)
                end = corners[index + 1] - cut[index] * direction
                arc = 2.0 * float(half[index]) / bend if bend > _STRAIGHT else 2.0 * float(cut[index])
                pieces.append((arc, end, direction, aside, bend))
        pieces = [piece for piece in pieces if piece[0] > 1e-12]
        self.knots: FloatArray = np.concatenate(([0.0], np.cumsum([piece[0] for piece in pieces])))
        self._start = np.array([piece[1] for piece in pieces])
        self._x = np.array([piece[2] for piece in pieces])
        self._y = np.array([piece[3] for piece in pieces])
        self._bend = np.array([piece[4] for piece in pieces])


_STRAIGHT = 1e-9  # [1/rad] curvature below which an arc is a line
