"""The magazine that gives the hand one sensor after the other."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse, transform

from .block import Block
from .scene import Scene
from .thing import Rest
from .world_file import BlockSpec, SensorSpec

NEAR = 0.01  # [rad], [m] of each joint from the posture `home`, at which the magazine meets the hand
BITE = 0.035  # [m] of a sensor's height that stands between the fingers


class Magazine:
    """Puts the next sensor between the open fingers when the arm is in its posture `home`, the hand empty.

    What the fingers let go there, it takes back.
    """

    STATE: ClassVar = {"_held": str}

    def __init__(self, scene: Scene, spec: SensorSpec) -> None:
        self.scene, self.spec = scene, spec
        self._home = np.array(scene.robot.posture("home"))
        opening = scene.robot.gripper.opening_mm / 1e3 if scene.robot.gripper else 0.0
        self._open = opening - 1e-3
        self._held = ""

    def step(self) -> None:
        """One period passes."""
        scene = self.scene
        before, self._held = self._held, scene.held.name if scene.held is not None else ""
        last = scene.blocks.get(str(scene.loaded))
        if last is not None and before == last.name != self._held and self._at_home():
            self._seat(last)
        if scene.loaded >= self.spec.count or scene.held is not None or scene.width < self._open:
            return
        waits = scene.blocks.get(str(scene.loaded))
        if waits is not None and waits.rest is Rest.TRAY:
            return
        if not self._at_home():
            return
        scene.loaded += 1
        name = str(scene.loaded)
        spec = BlockSpec(name=name, x_m=0.0, y_m=0.0, height_m=0.0, size_mm=self.spec.size_mm)
        scene.blocks[name] = Block(np.eye(4), Rest.TRAY, spec)
        self._seat(scene.blocks[name])

    def _at_home(self) -> bool:
        return float(np.abs(self.scene.joints - self._home).max()) < NEAR

    def _seat(self, sensor: Block) -> None:
        """Bring it between the fingers."""
        scene = self.scene
        sensor.pose, sensor.rest = scene.world_T("hand") @ self._hand_T_foot(), Rest.TRAY
        sensor.base_T_block = inverse(scene.world_T_base) @ sensor.pose
        scene.changes += 1

    def _hand_T_foot(self) -> Transform:
        """Of a sensor that hangs upright between the fingers: its z against the hand's x."""
        tip = self.scene.robot.finger_shape.tip
        ahead = tip - BITE + self.spec.size_mm[2] / 1e3
        return transform((ahead, 0.0, 0.0), (0.0, -np.pi / 2, 0.0))
