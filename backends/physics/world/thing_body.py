"""A thing as a body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.engine.thing_form import Cuboid, Piece, Rod, Sticks, ThingForm, Uvs
from handcart.backends.simulation.world.thing import Side, Thing
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

THING_FRICTION = 0.65  # squared, 0.42: paper on paper, paper on wood, wood on wood
BOX_SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y", "+z", "-z")
_SHADE = (0.6, 0.6, 0.75, 0.75, 1.1, 0.4)  # of the sides, as if light came from above
_STRIP = 32  # of a picture, a side's part of it is as wide and high, if all of them are plain [px]
_MOST = 512  # the same of one that is printed, at most
_INSET = 0.002  # of a side's part: not shown at its left and right, where another side's begins


class ThingBody:
    """Body of a movable thing in a physics engine, a rigid box whose sides are grey or printed.

    Subclasses change its shape or appearance. A domain (package for one kind of task) names the subclasses of
    its things in `Domain.physics`.
    """

    STICKS: ClassVar[Sticks | None] = None
    """Contact properties, if softer than the engine's."""

    def __init__(self, engine: Engine, thing: Thing) -> None:
        """Add the body at the pose of its thing; it may sleep until something touches it."""
        self.engine, self.thing = engine, thing
        self._mass = thing.mass
        self.id = engine.add_thing(self.form())

    def form(self) -> ThingForm:
        """Return the description of the body for a physics engine: pose, mass, shapes, friction and
        textures.
        """
        return ThingForm(
            self.thing.pose @ self.thing.thing_T_middle,
            self.thing.size,
            self._mass,
            self.pieces(),
            self.friction(),
            self.uvs(),
            self.first_picture(),
            self.STICKS,
            self.asleep(),
            self.thing.material,
            self.printed,
            self.thing.is_round,
            self.portrait,
        )

    def pieces(self) -> tuple[Piece, ...]:
        """Return the collision shapes of the body, in the frame at the thing's middle."""
        width, _, height = self.thing.size
        return (Rod(width / 2, height) if self.thing.is_round else Cuboid(self.thing.size),)

    def friction(self) -> float:
        """Return the body's coefficient of friction.

        Between two touching bodies the product of both coefficients acts.
        """
        return THING_FRICTION

    def uvs(self) -> tuple[Uvs, ...]:
        """Return the texture coordinates (u, v), 0 to 1, of the corners of the box's six faces, in the order
        -x, +x, -y, +y, +z, -z.
        """
        faces = self.thing.faces()
        return tuple(_part_of(number, side in faces) for number, side in enumerate(BOX_SIDES))

    def first_picture(self) -> ByteArray:
        """Return the grey texture (h, w) of all faces when the body is created, in which each face is at the
        texture coordinates that `uvs` returns.
        """
        return _picture(self.thing.faces(), self.thing.grey)

    def printed(self) -> ByteArray:
        """Return the grey texture (h, w) of all faces for a near camera, laid out in the picture by the
        coordinates that `uvs` returns.
        """
        return self.first_picture()

    def portrait(self) -> ByteArray | None:
        """Return the colour picture (h, w, 3), RGB, of all faces, for viewers in which a person watches; None
        if all faces are plain.

        The faces are laid out as in `first_picture`; plain faces have the colour of the material.
        """
        faces, material = self.thing.faces(), self.thing.material
        if not faces:
            return None
        white = _picture(faces, 0)[..., None].repeat(3, axis=2)
        size = white.shape[0]
        for number, side in enumerate(BOX_SIDES):
            if side not in faces:
                white[:, number * size : (number + 1) * size] = [round(255 * item) for item in material[:3]]
        return white

    def asleep(self) -> bool:
        """Return True if the body is not simulated (it sleeps) until another body touches it."""
        return False

    def look(self, eye: FloatArray) -> None:
        """Set the texture that a camera at `eye` should see on the body, which may be coarser from a
        distance.

        It is called before each picture.

        Args:
            eye: (3,) position of the camera in the world, in [m].
        """
        self.engine.show(self.id, self.first_picture())

    def keep(self) -> None:
        """Update the body's mass in the engine, at the beginning of a period, to the thing's mass, which may
        change.
        """
        if self.thing.mass != self._mass:
            self._mass = self.thing.mass
            self.engine.weigh(self.id, self._mass)


def _part_of(number: int, printed: bool) -> Uvs:
    """Return the corners (u, v) of a side in the picture of all sides; four times the middle of the side's
    part if it is plain.

    Args:
        number: number of the side: -x, +x, -y, +y, +z, -z.
        printed: True if something is printed on it.
    """
    if not printed:
        return (((number + 0.5) / len(BOX_SIDES), 0.5),) * 4
    left, right = (number + _INSET) / len(BOX_SIDES), (number + 1 - _INSET) / len(BOX_SIDES)
    return ((left, 0.0), (right, 0.0), (right, 1.0), (left, 1.0))


def _picture(faces: Mapping[Side, ByteArray], grey: int) -> ByteArray:
    """Return a grey picture (h, 6 h) of all sides beside each other: -x, +x, -y, +y, +z, -z.

    Args:
        faces: grey pictures (h, w) of the printed sides.
        grey: grey of the plain sides, 0 to 255.
    """
    shades = [min(255, round(grey * share)) for share in _SHADE]
    size = min(_MOST, max((max(face.shape) for face in faces.values()), default=_STRIP))
    return np.hstack(
        [_part(faces.get(side), shade, size) for side, shade in zip(BOX_SIDES, shades, strict=True)]
    )


def _part(picture: ByteArray | None, shade: int, size: int) -> ByteArray:
    import cv2

    if picture is None:
        return np.full((size, size), shade, np.uint8)
    return cv2.resize(picture, (size, size), interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
