"""The magazine that gives the hand one sensor after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from handcart.backends.scene.placed_thing import PlacedSpec
from handcart.backends.scene.thing import Rest
from handcart.robotics.geometry.transform import Transform, inverse, transform

from .sensor import Sensor

if TYPE_CHECKING:
    from .field_props import FieldProps
    from .spec import SensorSpec

NEAR = 0.01  # [rad], [m] of each joint from the posture `home`, at which the magazine meets the hand
BITE = 0.035  # [m] of a sensor's height that stands between the fingers


class Magazine:
    """Puts the next sensor between the open fingers when the arm is in its posture `home`, the hand empty.

    What the fingers let go there, it takes back.
    """

    def __init__(self, field: FieldProps, spec: SensorSpec) -> None:
        """Give sensors to `field`, whose state says how many so far."""
        self._field, self.scene, self.spec = field, field.scene, spec
        self._home = np.array(self.scene.robot.posture("home"))
        opening = self.scene.robot.gripper.opening_mm / 1e3 if self.scene.robot.gripper else 0.0
        self._open = opening - 1e-3

    def step(self) -> None:
        """One period passes."""
        field, scene = self._field, self.scene
        before, field.in_hand = field.in_hand, scene.held.name if scene.held is not None else ""
        last = field.sensors.get(str(field.loaded))
        if last is not None and before == last.name != field.in_hand and self._at_home():
            self._seat(last)
        if field.loaded >= self.spec.count or scene.held is not None or scene.width < self._open:
            return
        if self.waiting() is not None or not self._at_home():
            return
        field.loaded += 1
        name = str(field.loaded)
        spec = PlacedSpec(name=name, x_m=0.0, y_m=0.0, height_m=0.0, size_mm=self.spec.size_mm)
        field.sensors[name] = Sensor(np.eye(4), Rest.TRAY, spec)
        self._seat(field.sensors[name])

    def waiting(self) -> Sensor | None:
        """The sensor that it holds between the fingers."""
        sensor = self._field.sensors.get(str(self._field.loaded))
        return sensor if sensor is not None and sensor.rest is Rest.TRAY else None

    def _at_home(self) -> bool:
        return float(np.abs(self.scene.joints - self._home).max()) < NEAR

    def _seat(self, sensor: Sensor) -> None:
        """Bring it between the fingers."""
        scene = self.scene
        sensor.pose, sensor.rest = scene.world_T("hand") @ self._hand_T_foot(), Rest.TRAY
        sensor.base_T_thing = inverse(scene.world_T_base) @ sensor.pose
        scene.changes += 1

    def _hand_T_foot(self) -> Transform:
        """Of a sensor that hangs upright between the fingers: its z against the hand's x."""
        tip = self.scene.robot.finger_shape.tip
        ahead = tip - BITE + self.spec.size_mm[2] / 1e3
        return transform((ahead, 0.0, 0.0), (0.0, -np.pi / 2, 0.0))
