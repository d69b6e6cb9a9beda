"""Depth camera of a robot in Bullet."""

from __future__ import annotations

from itertools import product

import numpy as np
from typing_extensions import override

from handcart.backends.physics.sensors.engine_depth_camera import EngineDepthCamera
from handcart.backends.simulation.depth.simulated_depth_camera import TrueDepth
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

from .bullet_camera import render_with_depth
from .bullet_engine import BulletEngine

TILE_PX = (960, 720)
"""Largest picture that the EGL renderer draws at once, with room to spare."""


class BulletDepthCamera(EngineDepthCamera):
    """Simulated depth camera whose pictures are rendered by Bullet."""

    @override
    def _draw(self, world_T_camera: Transform) -> TrueDepth:
        assert isinstance(self._engine, BulletEngine)
        width, height = self._spec.width_px, self._spec.height_px
        colour = np.empty((height, width, 3), np.uint8)
        depth: FloatArray = np.empty((height, width))
        for top, left in product(range(0, height, TILE_PX[1]), range(0, width, TILE_PX[0])):
            K = self._spec.model.K.copy()
            K[:2, 2] -= (left, top)
            size = min(TILE_PX[0], width - left), min(TILE_PX[1], height - top)
            part = slice(top, top + size[1]), slice(left, left + size[0])
            colour[part], depth[part] = render_with_depth(self._engine, world_T_camera, K, size)
        return TrueDepth(colour, depth)
