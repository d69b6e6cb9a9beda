"""The key `footprint` of a robot's file: a disc, a rectangle or a polygon around the frame `base`."""

from __future__ import annotations

from functools import cached_property
from itertools import combinations
from typing import Annotated, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from handcart.files.models.model import FileModel
from handcart.robotics.geometry.footprint import Footprint, polygon
from handcart.robotics.numerics.arrays import FloatArray

MIN_INSCRIBED_M = 0.02
Positive = Annotated[float, Field(gt=0.0)]
Corner = tuple[float, float]
Point = FloatArray
ALLOWED_CORNERS = "allowed: three or more [x, y] in order around the base, in m"


class FootprintSpec(FileModel):
    """Outline in the base frame that covers the base, its load, and the arm in its travelling posture.

    Exactly one of the keys is given: a disc, a rectangle or a polygon.
    """

    radius_m: Positive | None = None
    """Radius of a disc around the origin of `base`."""
    rectangle_m: tuple[Positive, Positive] | None = None
    """Length along x and width along y of a rectangle with its middle at the origin of `base`."""
    corners_m: tuple[Corner, ...] | None = None
    """Corners x, y of a polygon around the origin of `base`, in order; it need not be convex."""

    @field_validator("corners_m")
    @classmethod
    def _check_corners(cls, corners: tuple[Corner, ...] | None) -> tuple[Corner, ...] | None:
        if corners is not None and (wrong := _wrong(np.array(corners).reshape(-1, 2))):
            raise ValueError(f"{wrong}; {ALLOWED_CORNERS}")
        return corners

    @field_validator("rectangle_m")
    @classmethod
    def _check_rectangle(cls, sides: tuple[float, float] | None) -> tuple[float, float] | None:
        if sides is not None and min(sides) < 2.0 * MIN_INSCRIBED_M:
            raise ValueError(f"a side is {min(sides):g} m; allowed: {2.0 * MIN_INSCRIBED_M:g} m or more")
        return sides

    @model_validator(mode="after")
    def _check_one(self) -> FootprintSpec:
        given = [key for key in ("radius_m", "rectangle_m", "corners_m") if getattr(self, key) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise ValueError(f"{found} given; allowed: one of radius_m, rectangle_m, corners_m")
        return self

    @property
    def shape(self) -> Footprint:
        """The base's footprint as a shape (disc or polygon) for collision checks."""
        if self.radius_m is not None:
            return Footprint(self.radius_m)
        if self.rectangle_m is not None:
            x, y = 0.5 * self.rectangle_m[0], 0.5 * self.rectangle_m[1]
            return polygon(np.array([[x, y], [-x, y], [-x, -y], [x, -y]]))
        return polygon(np.array(self.corners_m))


class OutlinedFile(FileModel):
    """Base class of files that describe a robot's footprint, as a radius or as a shape (`FootprintSpec`)."""

    footprint_radius_m: Annotated[float, Field(ge=0.0)] = 0.0
    """Radius of the circle around the base's centre that contains base, arm in its travelling posture, and
    load. (default: that of `footprint`)
    """
    footprint: FootprintSpec | None = None
    """Equivalent outline as a rectangle, a polygon or a disc; instead of `footprint_radius_m`."""

    @model_validator(mode="after")
    def _one_footprint(self) -> Self:
        """Set the radius around a footprint that is given as a shape."""
        if self.footprint is None:
            if self.footprint_radius_m <= 0.0:
                raise ValueError("no footprint; allowed: footprint, or footprint_radius_m above 0")
            return self
        radius = self.footprint.shape.radius
        if self.footprint_radius_m not in (0.0, radius):
            raise ValueError("footprint and footprint_radius_m are both given; allowed: one of them")
        self.__dict__["footprint_radius_m"] = radius
        return self

    @cached_property
    def footprint_shape(self) -> Footprint:
        """The footprint as geometry: a disc, or a polygon."""
        return Footprint(self.footprint_radius_m) if self.footprint is None else self.footprint.shape


def _wrong(corners: FloatArray) -> str:
    """Return what is wrong with the corners (n, 2) of a polygon; empty if nothing is."""
    count = len(corners)
    if count < 3:
        return f"{count} corner{'' if count == 1 else 's'}"
    for i in range(count):
        if np.hypot(*(corners[i] - corners[i - 1])) < 1e-6:
            return f"corner {i + 1} is the same as the one before it"
    for i, j in combinations(range(count), 2):
        apart = j - i not in (1, count - 1)
        if apart and _touch(corners[i], corners[(i + 1) % count], corners[j], corners[(j + 1) % count]):
            return f"the sides after corners {i + 1} and {j + 1} cross"
    shape = polygon(corners)
    if shape.inscribed < MIN_INSCRIBED_M:
        where = "outside" if shape.inscribed <= 0.0 else f"only {shape.inscribed:.3f} m from a side"
        return f"the origin of `base` is {where}, needed: {MIN_INSCRIBED_M:g} m inside"
    return ""


def _touch(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return True if the segments ab and cd cross or touch."""

    def side(p: Point, q: Point, r: Point) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    if side(a, b, c) == side(a, b, d) == 0.0:  # on one line: they touch if their boxes do
        low, high = np.minimum(a, b), np.maximum(a, b)
        return bool(np.all(np.maximum(c, d) >= low) and np.all(np.minimum(c, d) <= high))
    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0
