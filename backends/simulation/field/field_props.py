"""Objects of a field: sensors to lay, and the total station that measures their places."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.placed_thing import PlacedSpec
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.transform import Transform, inverse, transform

from .sensor import Sensor
from .spec import FieldSection, SeismicSensorSpec

# [rad], [m] of each joint from the posture `home`, at which the magazine meets the hand
HOME_TOLERANCE = 0.01
SENSOR_BITE_M = 0.035  # [m] of a sensor's height between the fingers


class FieldProps(Props[FieldSection]):
    """Seismic sensors of a simulated world, and the magazine on the robot that supplies them.

    The magazine puts the next sensor between the open fingers when the arm is in its posture `home` and the
    hand is empty. It takes back a sensor that the fingers let go there.
    """

    section = FieldSection
    STATE: ClassVar[Kinds] = {"sensors": dict[str, Sensor], "loaded": int, "in_hand": str}

    def __init__(self, scene: Scene, spec: FieldSection, seed: int) -> None:
        super().__init__(scene, spec, seed)
        self.sensors: dict[str, Sensor] = {}
        self.loaded = 0
        """Number of sensors that the magazine has given so far."""
        self.in_hand = ""
        """Name of the held object in the period before; "" for an empty hand."""
        self.total_station = spec.total_station
        """Instrument that measures the hand's position, used by evaluation."""
        self._magazine: SeismicSensorSpec | None = None
        if spec.sensors is not None and scene.robot.gripper is not None:
            self._magazine = spec.sensors
            self._home = np.array(scene.robot.posture("home"))
            self._open = scene.robot.gripper.opening_mm / 1e3 - 1e-3

    @override
    def things(self) -> Iterable[Sensor]:
        return self.sensors.values()

    @override
    def step(self) -> None:
        if self._magazine is not None:
            self._give(self._magazine)

    def _give(self, magazine: SeismicSensorSpec) -> None:
        scene = self.scene
        before, self.in_hand = self.in_hand, scene.held.name if scene.held is not None else ""
        last = self.sensors.get(str(self.loaded))
        if last is not None and before == last.name != self.in_hand and self._at_home():
            self._seat(last)
        if self.loaded >= magazine.count or scene.held is not None or scene.width < self._open:
            return
        if self.waiting() is not None or not self._at_home():
            return
        self.loaded += 1
        name = str(self.loaded)
        spec = PlacedSpec(name=name, x_m=0.0, y_m=0.0, height_m=0.0, size_mm=magazine.size_mm)
        self.sensors[name] = Sensor(np.eye(4), Rest.TRAY, spec)
        self._seat(self.sensors[name])

    def waiting(self) -> Sensor | None:
        """Return the sensor between the fingers that is still in the magazine; None if there is none."""
        sensor = self.sensors.get(str(self.loaded))
        return sensor if sensor is not None and sensor.rest is Rest.TRAY else None

    def rested(self, thing: Thing) -> None:
        """Update the support of a released thing, unless the magazine on the robot carries it."""
        if thing.rest is not Rest.TRAY:
            super().rested(thing)

    def _at_home(self) -> bool:
        return float(np.abs(self.scene.joints - self._home).max()) < HOME_TOLERANCE

    def _seat(self, sensor: Sensor) -> None:
        """Put a sensor between the fingers."""
        scene = self.scene
        sensor.pose, sensor.rest = scene.world_T("hand") @ self._hand_T_foot(sensor), Rest.TRAY
        sensor.base_T_thing = inverse(scene.world_T_base) @ sensor.pose
        scene.changes += 1

    def _hand_T_foot(self, sensor: Sensor) -> Transform:
        """Return hand_T_sensor (4, 4) of a sensor that hangs upright between the fingers: its z is opposite
        to the hand's x.
        """
        ahead = self.scene.robot.finger_shape.tip - SENSOR_BITE_M + sensor.size[2]
        return transform((ahead, 0.0, 0.0), (0.0, -np.pi / 2, 0.0))
