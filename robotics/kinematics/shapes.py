"""Convex bodies that stand for robot links, furniture and held objects."""

from __future__ import annotations

from dataclasses import dataclass

from robotics.geometry.transform import Transform


@dataclass(frozen=True, eq=False)
class Box:
    """A box about its centre: `pose` (4, 4), `size` along its own x, y, z in [m]."""

    pose: Transform
    size: tuple[float, float, float]
    name: str = "box"


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder about its centre: `pose` (4, 4), axis along its own z; `radius`, `length` in [m]."""

    pose: Transform
    radius: float
    length: float
    name: str = "cylinder"


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball about its centre: `pose` (4, 4), `radius` in [m]."""

    pose: Transform
    radius: float
    name: str = "sphere"


Shape = Box | Cylinder | Sphere
