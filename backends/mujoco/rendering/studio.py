"""Pictures of an engine's world; the stage is built again when something is added."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.backends.mujoco.body.robot_looks import PartLook
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .photographer import Photographer
from .stage import PictureStage
from .style import Style


class Studio:
    """Renderer of pictures of an engine's world, for one picture size and one style (light and colours).

    It builds its model for rendering again when bodies are added to the world.
    """

    def __init__(
        self, engine: MujocoEngine, robot: Sequence[PartLook], style: Style, size: tuple[int, int]
    ) -> None:
        """Prepare pictures; the stage is built at the first one.

        Args:
            engine: engine whose world is shown.
            robot: appearance of the robot's links.
            style: light and colours.
            size: width and height of the pictures, in [px].
        """
        self._engine, self._robot, self._style, self._size = engine, robot, style, size
        self._stage: PictureStage | None = None
        self._photographer: Photographer | None = None
        self._last: tuple[Transform, FloatArray, ByteArray] | None = None

    def take(self, world_T_camera: Transform, K: FloatArray, middle: FloatArray) -> ByteArray:
        """Return a picture (height, width, 3) in RGB, 0 to 255; if neither camera nor bodies have moved, it
        is the last picture again.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
            middle: (3,) point in the world at which the lamp is aimed, in [m].

        Raises:
            NoPictures: OpenGL is not available.
        """
        stage, photographer = self._set_up()
        moved = stage.follow(self._engine.links(), middle)
        last = self._last
        if not moved and last is not None and _same(last[0], world_T_camera) and (last[1] == K).all():
            return last[2]
        picture = photographer.take(world_T_camera, K)
        picture.flags.writeable = False
        self._last = world_T_camera.copy(), K.copy(), picture
        return picture

    def take_with_depth(self, world_T_camera: Transform, K: FloatArray) -> tuple[ByteArray, FloatArray]:
        """Return a picture (h, w, 3) in RGB, 0 to 255, and the depth (h, w) of its pixels.

        Depth is in [m] along the optical axis; infinite where nothing is.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.

        Raises:
            NoPictures: OpenGL is not available.
        """
        stage, photographer = self._set_up()
        stage.follow(self._engine.links(), world_T_camera[:3, 3])
        return photographer.take_with_depth(world_T_camera, K)

    def _set_up(self) -> tuple[PictureStage, Photographer]:
        if self._stage is None or self._photographer is None or self._stage.count != self._engine.looks.count:
            self.close()
            self._stage = PictureStage(self._engine.looks, self._robot, self._style, self._engine.model)
            self._photographer = Photographer(self._stage, self._size)
        return self._stage, self._photographer

    def close(self) -> None:
        """Release the OpenGL context; a second call does nothing."""
        if self._photographer is not None:
            self._photographer.close()
        self._stage = self._photographer = self._last = None


def _same(one: Transform, other: Transform) -> bool:
    return float(np.abs(one - other).max()) < 1e-5
