"""Pictures of what is in Bullet, and the textures of its bodies."""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from handcart.backends.physics.engine.engine import Point
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .bullet import quiet

_WARM_UP = 3  # pictures
_SUN = (-0.5, 0.4, 1.0)  # where light comes from in a picture for people
_UNLIT = 0.5  # of its own brightness is what the EGL renderer shows of a face that no light falls on


class BulletRenderer:
    """Renderer of pictures of a Bullet client's world, by the EGL plug-in if available or by TinyRenderer."""

    def __init__(self, p: Any, client: int, window: bool) -> None:
        """Start the renderer, before any shape is made.

        Args:
            p: the module of Bullet.
            client: number of the client.
            window: True if the client shows the world in a window.
        """
        self._p, self._client = p, client
        self._textures: dict[tuple[tuple[int, ...], bytes], int] = {}
        self._shown: dict[int, int] = {}
        self.number = self._start(window)
        """Bullet's number of the renderer."""
        self._cold = _WARM_UP if self.number == p.ER_BULLET_HARDWARE_OPENGL else 0

    def _start(self, window: bool) -> int:
        plugin = None if window else find_spec("eglRenderer")
        if plugin is not None and plugin.origin is not None:
            # Before any shape is made: the renderer shows what was made after it.
            with quiet():
                loaded = self._p.loadPlugin(plugin.origin, "_eglRendererPlugin", physicsClientId=self._client)
            if loaded >= 0:
                return int(self._p.ER_BULLET_HARDWARE_OPENGL)
        return int(self._p.ER_BULLET_HARDWARE_OPENGL if window else self._p.ER_TINY_RENDERER)

    # Textures

    def show(self, body: int, picture: ByteArray) -> None:
        """Set a grey picture (h, w), 0 to 255, as the texture of a body."""
        texture = self.texture(picture)
        if texture != self._shown.get(body):
            self._shown[body] = texture
            self._p.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=self._client)

    def texture(self, picture: ByteArray) -> int:
        """Return Bullet's texture number of a grey picture (h, w), which is loaded on the first call only."""
        key = (picture.shape, picture.tobytes())
        if key not in self._textures:
            self._textures[key] = self._load_texture(picture)
        return self._textures[key]

    def _load_texture(self, picture: ByteArray) -> int:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "texture.png")
            cv2.imwrite(path, cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
            return int(self._p.loadTexture(path, physicsClientId=self._client))

    # Pictures

    def picture(
        self, view: Transform, projection: Transform, size: tuple[int, int], lit: bool = False
    ) -> ByteArray:
        """Return the rendered picture (height, width, 3) in RGB.

        Args:
            view: (4, 4) camera_T_world in OpenGL's axes, in [m].
            projection: (4, 4) OpenGL's projection.
            size: width and height in [px].
            lit: True for a picture with light from above and shadows, as for videos; otherwise each surface
                is as bright as its paint.
        """
        width, height = size
        # The EGL renderer always has one light and shadows: from behind what is seen it falls on nothing.
        light = _SUN if lit else tuple((-view[2, :3]).tolist())
        with quiet():
            for _ in range(self._cold):  # the first pictures of the EGL renderer are lit otherwise
                self._render(view, projection, size, light)
            self._cold = 0
            image = self._render(view, projection, size, light)[2]
        picture = np.asarray(image, dtype=np.uint8).reshape(height, width, 4)[..., :3]
        if lit or self.number != self._p.ER_BULLET_HARDWARE_OPENGL:
            return picture
        return cv2.convertScaleAbs(picture, alpha=1 / _UNLIT).astype(np.uint8, copy=False)

    def picture_with_depth(
        self, view: Transform, projection: Transform, size: tuple[int, int]
    ) -> tuple[ByteArray, FloatArray]:
        """Return an unlit RGB picture (h, w, 3) of the world, and the values (h, w) of OpenGL's depth buffer,
        from 0 (nearest) to 1 (farthest).

        Args:
            view: (4, 4) camera_T_world in OpenGL's axes, in [m].
            projection: (4, 4) OpenGL's projection.
            size: width and height, in [px].
        """
        return self.picture(view, projection, size), self.depth_buffer(view, projection, size)

    def depth_buffer(self, view: Transform, projection: Transform, size: tuple[int, int]) -> FloatArray:
        """Return the values (h, w) of OpenGL's depth buffer, from 0 at the nearest plane to 1 at the farthest
        one.

        Args:
            view: (4, 4) camera_T_world in OpenGL's axes, in [m].
            projection: (4, 4) OpenGL's projection.
            size: width and height, in [px].
        """
        with quiet():
            buffer = self._render(view, projection, size, tuple((-view[2, :3]).tolist()))[3]
        return np.asarray(buffer, dtype=np.float64).reshape(size[1], size[0])

    def _render(self, view: Transform, projection: Transform, size: tuple[int, int], light: Point) -> Any:
        return self._p.getCameraImage(
            *size,
            view.T.ravel().tolist(),
            projection.T.ravel().tolist(),
            lightDirection=light,
            shadow=0,
            lightAmbientCoeff=1.0,
            lightDiffuseCoeff=0.0,
            lightSpecularCoeff=0.0,
            renderer=self.number,
            flags=self._p.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
