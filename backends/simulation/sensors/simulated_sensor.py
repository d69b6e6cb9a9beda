"""Base of all simulated sensors, and what they are given to be built."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.sensor_spec import SensorSpec
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.robotics.numerics.arrays import FloatArray

S = TypeVar("S", bound=SensorSpec, covariant=True)


@dataclass(frozen=True)
class SensorSite(Generic[S]):
    """Parts of a simulation that sensors are built from.

    `world`, `scene` and `engine` are ground truth, from which a simulation computes its readings.
    """

    name: str
    """Name of the sensor in the robot's file."""
    spec: S
    """Section of the sensor in the robot's file."""
    robot: RobotFile
    world: WorldFile
    scene: Scene
    period: float
    """Control period, in [s]."""
    seed: int
    """Seed of the sensor's errors: two sensors of one kind have different ones."""
    joints: Callable[[], FloatArray]
    """Function that returns the measured joints (n,) of the arm, in [rad] or [m]; an empty array without an
    arm.
    """
    link: str
    """Link of the URDF that the sensor is mounted at; "" for a sensor without a frame."""
    engine: Any = None
    """The simulation behind the scene, which some kinds of sensors know: with physics a
    `handcart.backends.physics.sensors.physics_site:PhysicsSite`.
    """


class SimulatedSensor(ABC):
    """Base class of simulated sensors; each also implements the interface of its kind, such as `Gps`.

    A simulation builds it with `build`, calls `advance` once a period, and saves the attributes of `STATE`
    in checkpoints.
    """

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types."""
    SETTLED_FIRST: ClassVar[bool] = False
    """True to build it only after a simulation with physics has come to rest: it measures at once."""

    @classmethod
    @abstractmethod
    def build(cls, site: SensorSite[Any]) -> SimulatedSensor:
        """Build the sensor from the parts of a simulation, such as its section of the robot's file.

        Raises:
            InputError: the sensor cannot be simulated for this robot.
        """

    @abstractmethod
    def advance(self, period: int) -> None:
        """Update the sensor's readings after a control period; `period` is the number of periods so far."""

    def close(self) -> None:
        """Release all resources; a second call does nothing."""
