"""Description of a thing from which an engine makes a body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.simulation.world.material import PALE_WOOD, Material
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray

Uvs = Sequence[tuple[float, float]]
"""Four corners (u, v) of a face in the picture: u to the right, v up, both from 0 to 1."""
BOX_FACES = np.array(
    (
        ((-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)),
        ((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)),
        ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)),
        ((1, 1, -1), (-1, 1, -1), (-1, 1, 1), (1, 1, 1)),
        ((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)),
        ((-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, -1)),
    ),
    dtype=float,
)
"""Corners (6, 4, 3) of a box's sides, x, y, z each -1 or 1, counter-clockwise as seen from outside; sides in
the order -x, +x, -y, +y, +z, -z.
"""
BOX_NORMALS = np.array(((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1)), dtype=float)
"""Outward unit normals (6, 3) of a box's sides, in the order of `BOX_FACES`."""


class Cuboid(NamedTuple):
    """Box as the shape of a simulated thing; its sides are along the axes of the thing's frame."""

    size: tuple[float, float, float]
    """Size along x, y and z, in [m]."""
    ahead: float = 0.0
    """Offset of the box's middle from the thing's middle along x, in [m]."""


class Rod(NamedTuple):
    """A cylinder as a shape of a thing, around its middle, along the z axis of the thing's frame."""

    radius: float
    """Radius, in [m]."""
    length: float
    """Length along z, in [m]."""


class Wedge(NamedTuple):
    """A blunt wedge as a shape of a thing, in [m], in the frame at the thing's middle.

    From x = `base` to x = `end` it narrows along y by `chamfer` on each side; `thickness` is its size along y
    at x = `base`, and `height` its size along z.
    """

    base: float
    end: float
    thickness: float
    height: float
    chamfer: float


Piece = Cuboid | Rod | Wedge


class Sticks(NamedTuple):
    """Contact stiffness and damping for a body that static friction has to keep at its place under small
    forces.
    """

    stiffness: float
    """Stiffness of each contact point, in [N/m]."""
    damping: float
    """Damping of each contact point, in [Ns/m]."""


class OnJoint(NamedTuple):
    """Mounting of a body on a joint that is fixed in the world, such as a door's hinge.

    All bodies with the same `label` are rigidly connected; the first of them is on the joint.
    """

    label: str
    joint: WorldJoint | None
    """Joint to the world; None: the body is fixed to the earlier one with the same label."""


class WorldJoint(NamedTuple):
    """A hinge or a slide that is fixed in the world; at the initial pose of the body that it carries, its
    position is 0.
    """

    slides: bool
    point: tuple[float, float, float]
    """Point (3,) on the axis, in the world, in [m]."""
    axis: tuple[float, float, float]
    """Unit vector (3,) along the axis, in the world."""
    limits: tuple[float, float]
    """Lowest and highest reading, in [rad] or [m]."""
    friction: float
    """Coulomb friction of the joint, in [Nm] or [N]."""
    damping: float
    """Viscous damping of the joint, in [Nms/rad] or [Ns/m]."""


class ThingForm(NamedTuple):
    """Initial pose, mass, shapes, friction and appearance of a rigid body, for a physics engine."""

    middle: Transform
    """Pose world_T_middle (4, 4) of its middle, which is its centre of mass."""
    size: tuple[float, float, float]
    """Size of its bounding box along x, y and z, in [m]."""
    mass: float
    """Mass, in [kg]."""
    pieces: tuple[Piece, ...]
    friction: float
    uvs: tuple[Uvs, ...]
    """Texture corners of the faces -x, +x, -y, +y, +z, -z of the bounding box.

    Four corners for each face, counter-clockwise as seen from outside. Those of the sides begin at the
    lower left, those of the upper face at (-x, -y), those of the lower face at (-x, +y).
    """
    picture: ByteArray
    """Picture (h, w), grey, of all faces at the creation of the body, laid out as `uvs` says."""
    sticks: Sticks | None = None
    asleep: bool = False
    """True if it sleeps from the beginning until something touches it."""
    material: Material = PALE_WOOD
    """Material of the unprinted faces, in pictures for people."""
    printed: Callable[[], ByteArray] | None = None
    """Function that returns the grey picture (h, w) for a near camera, laid out as `uvs` says; None to show
    `picture` always.
    """
    is_round: bool = False
    """True if it looks like a cylinder along z; only its ends can be printed."""
    portrait: Callable[[], ByteArray | None] | None = None
    """Function that returns the picture (h, w, 3) in RGB for people, laid out as `uvs` says; its result is
    None if nothing is printed.
    """
    hung: OnJoint | None = None
    """Joint of the world on which the thing moves; None: it moves freely."""
