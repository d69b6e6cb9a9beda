"""The camera of the simulated robot, drawn by Bullet's renderer."""

from __future__ import annotations

from itertools import product

import numpy as np

from handcart.backends.physics.sensors.engine_camera import SAMPLES_PER_SIDE, EngineCamera
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .bullet_engine import BulletEngine

NEAREST, FURTHEST = 0.02, 20.0  # of what is shown [m]
FINE_NEAREST = 0.1  # [m], of the second rendering of a depth camera
_TO_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


class BulletCamera(EngineCamera):
    """Simulated camera whose pictures are rendered by the physics engine Bullet.

    Bullet uses its EGL plug-in if available, otherwise TinyRenderer.
    """

    def _draw(self, world_T_camera: Transform, K: FloatArray, size: tuple[int, int]) -> ByteArray:
        """Render the picture (height, width), grey, in tiles, because the EGL renderer stretches its window
        of 1024 x 768 to larger sizes.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
            size: width and height in [px].
        """
        assert isinstance(self._engine, BulletEngine)
        width, height = size[0] // SAMPLES_PER_SIDE, size[1] // SAMPLES_PER_SIDE
        picture = np.empty((size[1], size[0]), dtype=np.uint8)
        for row, column in product(range(0, size[1], height), range(0, size[0], width)):
            moved = K.copy()
            moved[:2, 2] -= (column, row)
            tile = render(self._engine, world_T_camera, moved, (width, height))
            picture[row : row + height, column : column + width] = tile[..., 1]
        return picture


def render(
    engine: BulletEngine,
    world_T_camera: Transform,
    K: FloatArray,
    size: tuple[int, int],
    lit: bool = False,
) -> ByteArray:
    """Return the picture (height, width, 3) in RGB of a pinhole camera.

    Args:
        engine: engine with the bodies to render.
        world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
        K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
        size: width and height in [px].
        lit: True for light from above and shadows; otherwise each surface is as bright as its paint.
    """
    view = inverse(world_T_camera @ _TO_OPENGL)
    return engine.renderer.picture(view, _projection(K, size), size, lit)


def render_with_depth(
    engine: BulletEngine, world_T_camera: Transform, K: FloatArray, size: tuple[int, int]
) -> tuple[ByteArray, FloatArray]:
    """Return a picture (height, width, 3) in RGB, and the depth (height, width) of its pixels, in [m].

    Depth is along the optical axis, and infinite where nothing is nearer than 20 m (`FURTHEST`). Near and far
    depths are rendered separately, because OpenGL's depth buffer is coarse far away if its nearest plane is
    close.

    Args:
        engine: engine with the bodies to render.
        world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
        K: (3, 3) camera matrix, in [px].
        size: width and height in [px].
    """
    view = inverse(world_T_camera @ _TO_OPENGL)
    colour, close = engine.renderer.picture_with_depth(view, _projection(K, size), size)
    far = engine.renderer.depth_buffer(view, _projection(K, size, FINE_NEAREST), size)
    near_depth, far_depth = _depth(close, NEAREST), _depth(far, FINE_NEAREST)
    return colour, np.where(near_depth < 2.0 * FINE_NEAREST, near_depth, far_depth)


def _depth(part: FloatArray, nearest: float) -> FloatArray:
    """Return the depths (h, w) in [m] of OpenGL's depth buffer (h, w); infinite where it is 1.

    Args:
        part: (h, w) values of the buffer: 0 at the nearest plane, 1 at `FURTHEST`.
        nearest: depth of the nearest plane, in [m].
    """
    depth = FURTHEST * nearest / (FURTHEST - part * (FURTHEST - nearest))
    return np.where(part >= 1.0, np.inf, depth)


def _projection(K: FloatArray, size: tuple[int, int], near: float = NEAREST) -> FloatArray:
    """Return OpenGL's projection (4, 4) of a pinhole camera.

    OpenGL counts pixels from their edges, not from their centres.

    Args:
        K: (3, 3) camera matrix, in [px].
        size: width and height in [px].
        near: depth of the nearest plane, in [m].
    """
    width, height = size
    fx, fy, cx, cy = K[0, 0], K[1, 1], K[0, 2] + 0.5, K[1, 2] + 0.5
    far = FURTHEST
    return np.array(
        [
            [2 * fx / width, 0.0, 1.0 - 2 * cx / width, 0.0],
            [0.0, 2 * fy / height, 2 * cy / height - 1.0, 0.0],
            [0.0, 0.0, -(far + near) / (far - near), -2 * far * near / (far - near)],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )
