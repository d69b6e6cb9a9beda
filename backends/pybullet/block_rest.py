"""What carries a block."""

from __future__ import annotations

import numpy as np

from handcart.backends.scene.block import Block
from handcart.backends.scene.scene import Scene
from handcart.backends.scene.thing import Rest
from handcart.robotics.geometry.transform import inverse

_UPRIGHT = np.radians(10.0)
_ON = 0.005  # [m] by which its foot may lie below a support


def block_rest(scene: Scene, block: Block) -> Rest:
    """What carries a block that isn't held: the robot's own table, one of the world, or nothing of use.

    What stands on another block is carried by what carries that one. One that toppled is lost to the robot,
    wherever it lies.
    """
    if block.tilt() > _UPRIGHT:
        return Rest.FLOOR
    if scene.robot.has_tray:
        tray = scene.robot.tray_shape
        x, y, z = (inverse(scene.world_T_base) @ block.pose)[:3, 3]
        beside = np.abs(np.array((x, y)) - tray.middle) - np.array(tray.size[:2]) / 2
        if (beside < 0.0).all() and z > tray.top - _ON:
            return Rest.TRAY
    for solid in scene.solids:
        x, y, z = (inverse(solid.box.pose) @ block.pose)[:3, 3]
        length, width, height = solid.box.size
        if abs(x) < length / 2 and abs(y) < width / 2 and z > height / 2 - _ON:
            return Rest.TABLE
    return Rest.FLOOR
