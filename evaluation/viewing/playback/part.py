"""Part of a recorded run, as stored in one file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
import orjson
from numpy.typing import NDArray
from pydantic import TypeAdapter

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, IntArray, Uint16Array

from .scenery import ThingShape

PLAYBACK_FOLDER = "playback"
"""Subfolder of a run's folder that holds the scenery and the parts."""
SCENERY_FILE = "scenery.json"
PART_FILE_FORMAT = "{:05d}.npz"
"""File name of a part, by its number from 1."""
INVALID_RANGE_MM, NO_ECHO_MM = 65535, 65534
"""Stored values of an invalid range and of a range without an echo."""
SHAPES_ADAPTER = TypeAdapter(list[ThingShape])


class RecordingPart(NamedTuple):
    """States, lidar scans, particles, pictures and things of a run, as in one file of its recording.

    All times are in [s] and ascending; they are on the robot's clock, except for `world_time`.
    """

    time: FloatArray
    """(n,) time of each row."""
    world_time: FloatArray
    """(n,) time of the world, in [s]; it advances while the run is paused."""
    pose: FloatArray
    """(n, 3) estimated map_T_base: x, y in [m], heading in [rad]."""
    truth: FloatArray
    """(n, 7) true world_T_base as x, y, z in [m] and unit quaternion w, x, y, z; NaN where it is unknown."""
    joints: FloatArray
    """(n, j) measured joint positions, in [rad] or [m]."""
    width: FloatArray
    """(n,) measured opening of the gripper, in [m]; 0 without a gripper."""
    covariance: FloatArray
    """(n, 3, 3) covariance of the estimated pose, in [m] and [rad]."""
    action: IntArray
    """(n,) number of the running action, from 1; 0 before the first."""
    restoring: BoolArray
    """(n,) whether the action was restoring."""
    scan_time: FloatArray
    """(s,) time of each lidar scan."""
    scan_mm: Uint16Array
    """(s, b) range of each lidar beam, in [mm]; 65534 without an echo, 65535 if invalid."""
    cloud_time: FloatArray
    """(c,) time of each particle cloud."""
    cloud: FloatArray
    """(c, p, 3) particles of the localization: x, y in [m], heading in [rad]."""
    picture_time: FloatArray
    """(i,) time of each camera picture."""
    picture_end: IntArray
    """(i,) end index of each camera picture in `picture`."""
    picture: ByteArray
    """JPEG bytes of all camera pictures, concatenated."""
    moved_time: FloatArray
    """(k,) time of each change of a thing's pose."""
    moved_name: IntArray
    """(k,) index in `names` of the moved thing."""
    moved_pose: FloatArray
    """(k, 7) world_T_thing after the change, as x, y, z in [m] and unit quaternion w, x, y, z."""
    names: NDArray[np.str_]
    """Names of the things that moved in this part."""
    shapes: ByteArray
    """JSON bytes of a list of `ThingShape`, one for each thing that appears first in this part."""

    people_time: FloatArray
    """(q,) time of each tracked person's row; equal for those of one scan."""
    people: FloatArray
    """(q, 7) tracked people, each x, y in [m], velocity x, y in [m/s], and xx, xy, yy of the covariance in
    [m²].
    """

    @classmethod
    def of(cls, arrays: dict[str, NDArray[Any]]) -> Self:
        """Create a part from the arrays of a file, by field; shapes and units are those of the fields.

        Raises:
            ValueError: an array is missing, or has a wrong type or shape.
        """
        arrays = {"people_time": np.empty(0), "people": np.empty((0, 7)), **arrays}  # older files have none
        if missing := [name for name in cls._fields if name not in arrays]:
            raise ValueError(f"it has no {', '.join(missing)}")
        part = cls(**{name: arrays[name] for name in cls._fields})
        for names, leader in zip(_GROUPS, _LEADERS, strict=True):
            length = len(arrays[leader])
            for name in names:
                array = arrays[name]
                if array.dtype.kind not in _KINDS.get(name, "f") or array.shape[:1] != (length,):
                    raise ValueError(f"its {name} has a wrong type or shape: {array.dtype} {array.shape}")
        for name, size in _WIDTHS.items():
            if len(arrays[name]) and arrays[name].shape[1:] != size:
                raise ValueError(f"its {name} is of the shape {arrays[name].shape}; needed: (n, {size})")
        if len(part.moved_name) and not (
            0 <= part.moved_name.min() <= part.moved_name.max() < len(part.names)
        ):
            raise ValueError("something in it moves that has no name")
        return part

    def new_shapes(self) -> list[ThingShape]:
        """Return the shapes of the movable things whose first appearance in the run is in this part.

        Raises:
            ValueError: the recorded shapes are damaged.
        """
        return SHAPES_ADAPTER.validate_python(orjson.loads(self.shapes.tobytes()))

    def jpegs(self) -> list[bytes]:
        """Return the JPEG bytes of each camera picture."""
        raw, ends = self.picture.tobytes(), self.picture_end.tolist()
        return [raw[a:b] for a, b in zip([0, *ends], ends, strict=False)]

    def before(self, time: float) -> RecordingPart:
        """Return the part's data from before a time in [s]."""
        counts = [int(np.searchsorted(getattr(self, leader), time)) for leader in _LEADERS]
        cut: dict[str, Any] = {}
        for names, count in zip(_GROUPS, counts, strict=True):
            cut |= {name: getattr(self, name)[:count] for name in names}
        return self._replace(**cut)


_GROUPS: Sequence[Sequence[str]] = (
    RecordingPart._fields[:9],
    ("scan_time", "scan_mm"),
    ("cloud_time", "cloud"),
    ("picture_time", "picture_end"),
    ("moved_time", "moved_name", "moved_pose"),
    ("people_time", "people"),
)
_LEADERS = ("time", "scan_time", "cloud_time", "picture_time", "moved_time", "people_time")
_KINDS = {"action": "i", "restoring": "b", "scan_mm": "uf", "picture_end": "i", "moved_name": "i"}
_WIDTHS = {"pose": (3,), "truth": (7,), "covariance": (3, 3), "moved_pose": (7,), "people": (7,)}


def millimetres(ranges: FloatArray) -> Uint16Array:
    """Convert lidar ranges to integers (...,) in [mm], with codes for a missing echo and an invalid range.

    Args:
        ranges: (...,) in [m]; infinity without an echo, NaN or -infinity if invalid.
    """
    whole = np.clip(np.rint(1e3 * np.nan_to_num(ranges, nan=0.0, posinf=0.0, neginf=0.0)), 0, NO_ECHO_MM - 1)
    unknown = np.isnan(ranges) | np.isneginf(ranges)
    return np.where(unknown, INVALID_RANGE_MM, np.where(np.isinf(ranges), NO_ECHO_MM, whole)).astype(
        np.uint16
    )


def metres(scan_mm: Uint16Array) -> FloatArray:
    """Return lidar ranges (...,) in [m], given as integers in [mm]; infinity without an echo, NaN if invalid.

    Args:
        scan_mm: (...,) encoded by `millimetres`.
    """
    known = scan_mm / 1e3
    return np.where(scan_mm == INVALID_RANGE_MM, np.nan, np.where(scan_mm == NO_ECHO_MM, np.inf, known))
