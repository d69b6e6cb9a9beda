"""Takes pictures of a stage."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .gl_context import make_context
from .stage import PictureStage

NEAREST, FURTHEST = 0.02, 60.0  # of what is shown [m]
_MOST = 20_000  # shapes


class Photographer:
    """Renderer of pictures of a scene, for any camera pose and intrinsics.

    It renders MuJoCo's model of the scene for pictures (`PictureStage`).
    """

    def __init__(self, stage: PictureStage, size: tuple[int, int]) -> None:
        """Prepare pictures of a width and height `size` in [px].

        Raises:
            NoPictures: OpenGL is not available.
        """
        mj, self._stage, self._size = mujoco(), stage, size
        stage.model.vis.global_.offwidth, stage.model.vis.global_.offheight = size
        self._gl = make_context(*size)
        self._scene = mj.MjvScene(stage.model, _MOST)
        self._context = mj.MjrContext(stage.model, mj.mjtFontScale.mjFONTSCALE_100)
        mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._options, self._camera = mj.MjvOption(), mj.MjvCamera()
        self._options.geomgroup[:] = 1
        self._rows = np.zeros((size[1], size[0], 3), np.uint8)

    def take(self, world_T_camera: Transform, K: FloatArray) -> ByteArray:
        """Return a picture (height, width, 3) in RGB, 0 to 255.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
        """
        whole = self._render(world_T_camera, K)
        mujoco().mjr_readPixels(self._rows, None, whole, self._context)
        return np.ascontiguousarray(self._rows[::-1])

    def take_with_depth(self, world_T_camera: Transform, K: FloatArray) -> tuple[ByteArray, FloatArray]:
        """Return a picture (h, w, 3) in RGB, 0 to 255, and the depth (h, w) of each pixel.

        Depth is in [m] along the optical axis; infinite where nothing is.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px]; an integer pixel is a pixel's centre.
        """
        mj, whole = mujoco(), self._render(world_T_camera, K)
        self._context.readDepthMap = mj.mjtDepthMap.mjDEPTH_ZEROFAR
        buffer = np.zeros(self._rows.shape[:2], np.float32)
        mj.mjr_readPixels(self._rows, buffer, whole, self._context)
        part = buffer[::-1].astype(np.float64)  # OpenGL's depth: 1 at the near plane, 0 at the far one
        depth = FURTHEST * NEAREST / (part * (FURTHEST - NEAREST) + NEAREST)
        depth[part <= 0.0] = np.inf
        return np.ascontiguousarray(self._rows[::-1]), depth

    def _render(self, world_T_camera: Transform, K: FloatArray) -> Any:
        """Draw the picture into OpenGL's buffer, and return its rectangle as MuJoCo's `MjrRect`.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px].
        """
        mj, stage = mujoco(), self._stage
        self._gl.make_current()
        for texture in stage.repaint():
            mj.mjr_uploadTexture(stage.model, self._context, texture)
        every = mj.mjtCatBit.mjCAT_ALL
        mj.mjv_updateScene(stage.model, stage.data, self._options, None, self._camera, every, self._scene)
        for eye in self._scene.camera:
            self._point(eye, world_T_camera, K)
        whole = mj.MjrRect(0, 0, *self._size)
        mj.mjr_render(whole, self._scene, self._context)
        return whole

    def _point(self, eye: Any, world_T_camera: Transform, K: FloatArray) -> None:
        """Set one of the scene's two eyes to a camera's pose and intrinsics.

        OpenGL counts pixels from their edges, not from their centres.

        Args:
            eye: MuJoCo's camera of the scene.
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            K: (3, 3) camera matrix, in [px].
        """
        width, height = self._size
        (fx, _, cx), (_, fy, cy), _ = K.tolist()
        eye.pos = world_T_camera[:3, 3]
        eye.forward, eye.up = world_T_camera[:3, 2], -world_T_camera[:3, 1]
        eye.orthographic, eye.frustum_near, eye.frustum_far = 0, NEAREST, FURTHEST
        eye.frustum_center = NEAREST * (width / 2 - (cx + 0.5)) / fx
        eye.frustum_width = NEAREST * width / 2 / fx
        eye.frustum_top = NEAREST * (cy + 0.5) / fy
        eye.frustum_bottom = -NEAREST * (height - (cy + 0.5)) / fy

    def close(self) -> None:
        """Release the OpenGL context; a second call does nothing."""
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl.free()
            self._gl = None
