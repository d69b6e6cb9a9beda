"""What an engine is told of a thing to make a body of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.simulation.world.material import PALE_WOOD, Material
from handcart.backends.simulation.world.thing import GreyImage
from handcart.robotics.geometry.transform import Transform

BOX_FACES = (
    ((-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)),
    ((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)),
    ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)),
    ((1, 1, -1), (-1, 1, -1), (-1, 1, 1), (1, 1, 1)),
    ((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)),
    ((-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, -1)),
)
"""Of a box from -1 to 1: -x, +x, -y, +y, +z, -z; corners counter-clockwise from outside."""
BOX_NORMALS = ((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1))
"""Of the same faces."""
Uvs = Sequence[tuple[float, float]]
"""Where a face's corners lie in the picture: u to the right, v up, both from 0 to 1."""


Portrait = NDArray[np.uint8]
"""A picture in colour, (height, width, 3) in RGB."""


class Cuboid(NamedTuple):
    """A box, its sides along the axes of the thing's middle."""

    size: tuple[float, float, float]
    """[m]"""
    ahead: float = 0.0
    """Of its middle along x, in [m]."""


class Wedge(NamedTuple):
    """A prism whose face at x = `base` narrows along y by `chamfer` on each side up to x = `end`, in [m]."""

    base: float
    end: float
    thickness: float
    height: float
    chamfer: float


class Sticks(NamedTuple):
    """Of a body that stays where it stands, however little pushes it: each point at which it touches."""

    stiffness: float
    """[N/m]"""
    damping: float
    """[Ns/m]"""


class ThingForm(NamedTuple):
    """A rigid body, where it is and how it looks."""

    middle: Transform
    """World pose (4, 4) of its middle, which is that of its mass."""
    size: tuple[float, float, float]
    """Of the box about it, in [m]."""
    mass: float
    """[kg]"""
    pieces: tuple[Cuboid | Wedge, ...]
    friction: float
    uvs: tuple[Uvs, ...]
    """Of the faces -x, +x, -y, +y, +z, -z of the box about it: four corners each, counter-clockwise from
    outside; of the sides from the foot on their left, of the upper one from (-x, -y), of the lower one
    from (-x, +y)."""
    picture: GreyImage
    """That the faces show parts of, at first."""
    sticks: Sticks | None = None
    asleep: bool = False
    """Whether it sleeps until something touches it, from the beginning."""
    material: Material = PALE_WOOD
    """Of what isn't printed, for people."""
    printed: Callable[[], GreyImage] | None = None
    """All that its faces show to a camera that is near, laid out as `uvs` says; None: as `picture`."""
    portrait: Callable[[], Portrait | None] | None = None
    """The same in colour, for people; None where nothing is printed."""
