"""A thing as Bullet's body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from handcart.backends.pybullet.physics import Physics, placed
from handcart.backends.simulation.world.thing import GreyImage, Side, Thing

from .box_mesh import box_mesh

THING_FRICTION = 0.65  # squared, 0.42: paper on paper, paper on wood, wood on wood
SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y", "+z", "-z")
_SHADE = (0.6, 0.6, 0.75, 0.75, 1.1, 0.4)  # of the sides, as if light came from above
_STRIP = 32  # of a picture, a side's part of it is as wide and high, if all of them are plain [px]
_MOST = 512  # the same of one that is printed, at most
_INSET = 0.002  # of a side's part: not shown at its left and right, where another side's begins


class ThingBody:
    """A rigid box with the thing's mass, each side in a grey of its own or printed.

    Subclasses, named by `Domain.physics`, make another shape or look of it.
    """

    def __init__(self, physics: Physics, thing: Thing) -> None:
        """Make it where the thing is; asleep until something touches it."""
        self.physics, self.thing = physics, thing
        self._mass, self._texture = thing.mass, -1
        p, client, pose = physics.p, physics.client, thing.pose @ thing.thing_T_middle
        shape, visual = self.shape(), self.visual()
        self.id = int(p.createMultiBody(self._mass, shape, visual, *placed(pose), physicsClientId=client))
        self.look(None)
        self.settle()
        p.changeDynamics(
            self.id,
            -1,
            lateralFriction=THING_FRICTION,
            activationState=self.activation(),
            physicsClientId=client,
        )

    def shape(self) -> int:
        """Bullet's collision shape, about the thing's middle."""
        p, half = self.physics.p, [size / 2 for size in self.thing.size]
        return int(p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=self.physics.client))

    def visual(self) -> int:
        """Bullet's visual shape, about the thing's middle."""
        faces = self.thing.faces()
        uvs = [_part_of(number, side in faces) for number, side in enumerate(SIDES)]
        return box_mesh(self.physics, self.thing.size, uvs)

    def settle(self) -> None:
        """The body was made: set what else there is to its dynamics."""

    def activation(self) -> int:
        """Bullet's activation state."""
        return int(self.physics.p.ACTIVATION_STATE_ENABLE_SLEEPING)

    def look(self, eye: NDArray[np.float64] | None) -> None:
        """A picture is taken from `eye` (3,) in [m], None: it is made; have it look as it should."""
        texture = self.physics.texture(_picture(self.thing.faces(), self.thing.grey))
        if texture != self._texture:
            self._texture = texture
            p, client = self.physics.p, self.physics.client
            p.changeVisualShape(self.id, -1, textureUniqueId=texture, physicsClientId=client)

    def keep(self) -> None:
        """A period begins: see that it weighs what the thing weighs."""
        if self.thing.mass != self._mass:
            self._mass = self.thing.mass
            self.physics.p.changeDynamics(self.id, -1, mass=self._mass, physicsClientId=self.physics.client)


def _part_of(number: int, printed: bool) -> Sequence[tuple[float, float]]:
    """Where the corners of a side lie in the picture of all: in the middle of its part if it is plain."""
    if not printed:
        return (((number + 0.5) / len(SIDES), 0.5),) * 4
    left, right = (number + _INSET) / len(SIDES), (number + 1 - _INSET) / len(SIDES)
    return ((left, 0.0), (right, 0.0), (right, 1.0), (left, 1.0))


def _picture(faces: Mapping[Side, GreyImage], grey: int) -> GreyImage:
    """All sides beside each other, each as wide and high as the largest picture of one."""
    shades = [min(255, round(grey * share)) for share in _SHADE]
    size = min(_MOST, max((max(each.shape) for each in faces.values()), default=_STRIP))
    return np.hstack([_part(faces.get(side), shade, size) for side, shade in zip(SIDES, shades, strict=True)])


def _part(picture: GreyImage | None, shade: int, size: int) -> GreyImage:
    import cv2

    if picture is None:
        return np.full((size, size), shade, np.uint8)
    return cv2.resize(picture, (size, size), interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
