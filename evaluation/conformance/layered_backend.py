"""Another backend behind the same face: what faults and liars are made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from handcart.backends.arm import Arm
from handcart.backends.backend import Backend
from handcart.backends.base import Base, WheelTravel
from handcart.backends.camera import Camera
from handcart.backends.capability import Capability
from handcart.backends.gripper import Gripper
from handcart.backends.positioning import PoseReading, Positioning
from handcart.backends.range_sensor import RangeSensor, Scan
from handcart.backends.robot_file import RobotFile
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.perception.camera_model import CameraModel


class LayeredBackend(Backend):
    """Passes everything on to the backend inside. A subclass overrides what it changes.

    Each capability that the kit knows gets a layer of its own, which asks this object; others are handed
    out as they are.
    """

    def __init__(self, inner: Backend) -> None:
        self.inner = inner
        self.name, self.period = inner.name, inner.period
        self._layers = tuple(self._layer(part) for part in inner.capabilities())

    def _layer(self, part: Capability) -> Capability:
        match part:
            case Base():
                return LayeredBase(self, part)
            case Arm():
                return LayeredArm(self, part)
            case Gripper():
                return LayeredGripper(self, part)
            case Camera():
                return LayeredCamera(self, part)
            case RangeSensor():
                return LayeredRangeSensor(self, part)
            case Positioning():
                return LayeredPositioning(self, part)
        return part

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """Not by name: a layer is put around a backend that is there."""
        raise TypeError(f"{cls.__name__} is made around another backend")

    def capabilities(self) -> tuple[Capability, ...]:
        """See `Backend`."""
        return self._layers

    def step(self) -> None:
        """See `Backend`."""
        self.inner.step()

    def stop(self) -> None:
        """See `Backend`."""
        self.inner.stop()

    def close(self) -> None:
        """See `Backend`."""
        self.inner.close()

    # What the layers ask. Each gets the capability inside.

    def drive(self, base: Base, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        base.drive(speed, turn_rate)

    def wheel_travel(self, base: Base) -> WheelTravel:
        """See `Base`."""
        return base.wheel_travel()

    def move_arm(self, arm: Arm, joints: NDArray[np.float64]) -> None:
        """See `Arm`."""
        arm.move(joints)

    def arm_command(self, arm: Arm) -> NDArray[np.float64]:
        """See `Arm`."""
        return arm.command()

    def joints(self, arm: Arm) -> NDArray[np.float64]:
        """See `Arm`."""
        return arm.joints()

    def hand_force(self, arm: Arm) -> NDArray[np.float64]:
        """See `Arm`."""
        return arm.hand_force()

    def move_gripper(self, gripper: Gripper, width: float) -> None:
        """See `Gripper`."""
        gripper.move(width)

    def gripper_command(self, gripper: Gripper) -> float:
        """See `Gripper`."""
        return gripper.command()

    def width(self, gripper: Gripper) -> float:
        """See `Gripper`."""
        return gripper.width()

    def closed(self, gripper: Gripper) -> bool:
        """See `Gripper`."""
        return gripper.closed_on_something()

    def image(self, camera: Camera) -> NDArray[np.uint8]:
        """See `Camera`."""
        return camera.image()

    def scan(self, sensor: RangeSensor) -> Scan:
        """See `RangeSensor`."""
        return sensor.scan()

    def whereabouts(self, positioning: Positioning) -> PoseReading | None:
        """See `Positioning`."""
        return positioning.reading()


class LayeredBase(Base):
    """The wheels of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: Base) -> None:
        self._whole, self.inner = whole, inner

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        self._whole.drive(self.inner, speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return self._whole.wheel_travel(self.inner)


class LayeredArm(Arm):
    """The arm of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: Arm) -> None:
        self._whole, self.inner = whole, inner

    def move(self, joints: NDArray[np.float64]) -> None:
        """See `Arm`."""
        self._whole.move_arm(self.inner, joints)

    def command(self) -> NDArray[np.float64]:
        """See `Arm`."""
        return self._whole.arm_command(self.inner)

    def joints(self) -> NDArray[np.float64]:
        """See `Arm`."""
        return self._whole.joints(self.inner)

    def hand_force(self) -> NDArray[np.float64]:
        """See `Arm`."""
        return self._whole.hand_force(self.inner)


class LayeredGripper(Gripper):
    """The gripper of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: Gripper) -> None:
        self._whole, self.inner = whole, inner

    def command(self) -> float:
        """See `Gripper`."""
        return self._whole.gripper_command(self.inner)

    def move(self, width: float) -> None:
        """See `Gripper`."""
        self._whole.move_gripper(self.inner, width)

    def width(self) -> float:
        """See `Gripper`."""
        return self._whole.width(self.inner)

    def closed_on_something(self) -> bool:
        """See `Gripper`."""
        return self._whole.closed(self.inner)


class LayeredCamera(Camera):
    """The camera of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: Camera) -> None:
        self._whole, self.inner = whole, inner

    def image(self) -> NDArray[np.uint8]:
        """See `Camera`."""
        return self._whole.image(self.inner)

    @property
    def model(self) -> CameraModel:
        """See `Camera`."""
        return self.inner.model

    @property
    def hand_T_camera(self) -> Transform:
        """See `Camera`."""
        return self.inner.hand_T_camera


class LayeredRangeSensor(RangeSensor):
    """The range sensor of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: RangeSensor) -> None:
        self._whole, self.inner = whole, inner

    def scan(self) -> Scan:
        """See `RangeSensor`."""
        return self._whole.scan(self.inner)


class LayeredPositioning(Positioning):
    """The indoor positioning of a layered backend."""

    def __init__(self, whole: LayeredBackend, inner: Positioning) -> None:
        self._whole, self.inner = whole, inner

    def reading(self) -> PoseReading | None:
        """See `Positioning`."""
        return self._whole.whereabouts(self.inner)
