"""A stretch of a recorded run, as one file has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
import orjson
from numpy.typing import NDArray
from pydantic import TypeAdapter

from .scenery import ThingShape

FOLDER = "playback"
"""In a run's folder: the scenery, and the parts."""
SCENERY = "scenery.json"
NAME = "{:05d}.npz"
"""Of a part, by its number from 1."""
NOTHING, FAR = 65535, 65534
"""[mm] of a range that is no number, and of one where nothing came back."""
Array = NDArray[np.float64]
SHAPES = TypeAdapter(list[ThingShape])


class Part(NamedTuple):
    """Its arrays; times are the robot's, in [s], and rise."""

    time: Array
    """(n,) of the rows."""
    world_time: Array
    """(n,) in [s]: goes on while the run is paused."""
    pose: Array
    """(n, 3) estimated map_T_base: x, y in [m], heading in [rad]."""
    truth: Array
    """(n, 7) world_T_base; NaN where nobody knows."""
    joints: Array
    """(n, j) measured, in [rad] or [m]."""
    width: Array
    """(n,) between the fingers, in [m]; 0 without a gripper."""
    covariance: Array
    """(n, 3, 3) of the estimate, in [m] and [rad]."""
    action: NDArray[np.int64]
    """(n,) number of the action that ran, from 1; 0 before the first."""
    restoring: NDArray[np.bool_]
    """(n,) whether it was bringing everything back."""
    scan_time: Array
    """(s,)"""
    scan_mm: NDArray[np.uint16]
    """(s, b) range of each beam; 65534 where nothing came back, 65535 for what is no number."""
    cloud_time: Array
    """(c,)"""
    cloud: Array
    """(c, p, 3) of the localization's particles: x, y in [m], heading in [rad]."""
    picture_time: Array
    """(i,)"""
    picture_end: NDArray[np.int64]
    """(i,) where each picture ends in `picture`."""
    picture: NDArray[np.uint8]
    """JPEG after JPEG."""
    moved_time: Array
    """(k,)"""
    moved_name: NDArray[np.int64]
    """(k,) which of `names`."""
    moved_pose: Array
    """(k, 7) world_T_thing from then on."""
    names: NDArray[np.str_]
    """Of things that are somewhere else now."""
    shapes: NDArray[np.uint8]
    """JSON: a list of `ThingShape`, of things that are new."""

    @classmethod
    def of(cls, arrays: dict[str, NDArray[Any]]) -> Self:
        """Of a file's arrays.

        Raises:
            ValueError: one is missing, or isn't of the kind or size that it should be.
        """
        if missing := [name for name in cls._fields if name not in arrays]:
            raise ValueError(f"it has no {', '.join(missing)}")
        part = cls(**{name: arrays[name] for name in cls._fields})
        for names, leader in zip(_GROUPS, _LEADERS, strict=True):
            length = len(arrays[leader])
            for name in names:
                array = arrays[name]
                if array.dtype.kind not in _KINDS.get(name, "f") or array.shape[:1] != (length,):
                    raise ValueError(f"its {name} is no such array: {array.dtype} {array.shape}")
        for name, size in _WIDTHS.items():
            if len(arrays[name]) and arrays[name].shape[1:] != size:
                raise ValueError(f"its {name} is of the shape {arrays[name].shape}; needed: (n, {size})")
        if len(part.moved_name) and not (
            0 <= part.moved_name.min() <= part.moved_name.max() < len(part.names)
        ):
            raise ValueError("something in it moves that has no name")
        return part

    def new_shapes(self) -> list[ThingShape]:
        """Of things that are first seen here; raises ValueError where they aren't such."""
        return SHAPES.validate_python(orjson.loads(self.shapes.tobytes()))

    def jpegs(self) -> list[bytes]:
        """Each picture."""
        raw, ends = self.picture.tobytes(), self.picture_end.tolist()
        return [raw[a:b] for a, b in zip([0, *ends], ends, strict=False)]

    def before(self, time: float) -> Part:
        """What of it was before a moment, in [s]."""
        rows, scans, clouds, pictures, moves = (
            int(np.searchsorted(each, time))
            for each in (self.time, self.scan_time, self.cloud_time, self.picture_time, self.moved_time)
        )
        cut: dict[str, Any] = {}
        for names, count in zip(_GROUPS, (rows, scans, clouds, pictures, moves), strict=True):
            cut |= {name: getattr(self, name)[:count] for name in names}
        return self._replace(**cut)


_GROUPS: Sequence[Sequence[str]] = (
    Part._fields[:9],
    ("scan_time", "scan_mm"),
    ("cloud_time", "cloud"),
    ("picture_time", "picture_end"),
    ("moved_time", "moved_name", "moved_pose"),
)
_LEADERS = ("time", "scan_time", "cloud_time", "picture_time", "moved_time")
_KINDS = {"action": "i", "restoring": "b", "scan_mm": "uf", "picture_end": "i", "moved_name": "i"}
_WIDTHS = {"pose": (3,), "truth": (7,), "covariance": (3, 3), "moved_pose": (7,)}


def millimetres(ranges: Array) -> NDArray[np.uint16]:
    """Of ranges in [m], any shape."""
    whole = np.clip(np.rint(1e3 * np.nan_to_num(ranges, nan=0.0, posinf=0.0, neginf=0.0)), 0, FAR - 1)
    unknown = np.isnan(ranges) | np.isneginf(ranges)
    return np.where(unknown, NOTHING, np.where(np.isinf(ranges), FAR, whole)).astype(np.uint16)


def metres(scan_mm: NDArray[np.uint16]) -> Array:
    """Ranges in [m] of what `millimetres` gave."""
    known = scan_mm / 1e3
    return np.where(scan_mm == NOTHING, np.nan, np.where(scan_mm == FAR, np.inf, known))
