"""The base class of all backends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import HandcartError, InputError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import ByteArray

from .ground_truth import GroundTruth
from .recording import Recording
from .saved_state import NotAState

CapabilityT = TypeVar("CapabilityT", bound=Capability)


class CommandError(HandcartError, ValueError):
    """Error: a command is not finite, or beyond a limit of the robot's file."""


class RobotFault(HandcartError):
    """Error: the robot cannot be driven any more; it has been stopped, and a person has to look at it."""

    exit_status = 4


class NoBench(InputError):
    """Error: simulated drives were requested for a backend without drives."""


class NotMovable(InputError):
    """Error: a backend cannot start its robot at a pose other than the initial pose in the world's file."""


class NoWindow(InputError):
    """Error: a window was requested from a backend that has none, or no display is available."""


class Backend(ABC):
    """Interface of a robot: a stub, a simulator, or hardware.

    A backend returns raw readings as hardware would, with the hardware's errors; `Robot` computes everything
    derived from them, the same for all backends. It is a context manager; leaving the context closes the
    backend.
    """

    name: str
    """Name for `--backend`."""
    period: float
    """The control period, in [s]."""
    has_drives: ClassVar[bool] = False
    """True if simulated drives can be put in front of a simulated backend; see `build_on_bench`."""
    drive_kinds: ClassVar[frozenset[str]] = frozenset({"differential", "ackermann"})
    """Kinds of drives in a robot's file that the backend can drive."""
    lacks: ClassVar[frozenset[str]] = frozenset()
    """Keys of a world's file, such as `doors`, whose things the backend refuses to simulate."""
    simulated: bool = True
    """True if `build` creates a new world; False for a real one, which is as the last run left it."""
    address: str = ""
    """Address of the robot if several are reachable from this machine, such as `socketcan can0`."""
    remarks: Sequence[str] = ()
    """Differences between the robot and its files, printed before a run."""
    recording: Recording | None = None
    """Recorder of the traffic between program and robot; None without one."""

    @classmethod
    @abstractmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """Build a backend from a robot's file.

        Args:
            robot: robot file.
            world: file of the surroundings; simulated backends need one, others ignore it.
            seed: seed of simulated errors.

        Raises:
            FileError: the world's file is missing or invalid.
        """

    @classmethod
    def read_world(cls, path: Path, start: Pose2) -> Any:
        """Return a world that `build` accepts, read from a world's file, or from a map with the robot at
        `start`.

        Args:
            path: a world's file, or a map in ROS format.
            start: initial world_T_base in a map's world; a world's file has its own.

        Returns:
            The world; None if `build` reads the file itself. `build` then gets a temporary world's file in
            place of a map.

        Raises:
            FileError: the file is missing or something in it is wrong.
        """
        return None

    @classmethod
    def with_start(cls, world: Any, start: Pose2) -> Any:
        """Return a world, as `read_world` returned it, with `start` (world_T_base) as the robot's initial
        pose.

        Raises:
            NotMovable: the backend cannot put its robot at a given pose.
        """
        raise NotMovable(
            f"the backend {cls.name!r} cannot put its robot at a given place; "
            "allowed: no start place, or a simulated backend of handcart"
        )

    @classmethod
    def build_in_window(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """Build the backend of a robot in a world, with simulated errors drawn from `seed`, and show both in
        a window.

        Raises:
            NoWindow: the backend has no window, or no display is available.
        """
        raise NoWindow(
            f"the backend {cls.name!r} has no window; allowed: a video of the run, --video FILE.mp4"
        )

    @classmethod
    def kinds(cls, robot: RobotFile) -> tuple[type[Capability], ...] | None:
        """Return the classes of a robot's capabilities by its file alone, without connecting to the robot.

        None if the capabilities are known only after the backend was built; `handcart check` then builds the
        backend. A backend that connects to a real robot when it is built must not return None.

        Raises:
            InputError: the backend cannot build the robot that the file describes.
        """
        return None

    @classmethod
    def build_on_bench(cls, robot: RobotFile, world: Path | None, seed: int, bench: type[Backend]) -> Backend:
        """Build this backend on a bench, which consists of simulated drives that move a simulated robot.

        Args:
            robot: robot file.
            world: file of the surroundings; None without one.
            seed: seed of simulated errors.
            bench: class of the simulated backend whose robot the drives move.

        Raises:
            NoBench: this backend has no drives, or they cannot move a robot of the simulated backend.
        """
        raise NoBench(f"the backend {cls.name!r} has no drives; allowed: --bench with --backend can or ros2")

    @property
    def inner(self) -> Backend | None:
        """Simulated backend whose robot is moved by this backend's simulated drives; None for a backend that
        is not on a bench.
        """
        return None

    def ground_truth(self) -> GroundTruth | None:
        """Return the true state of robot and world, only for evaluation; None if it is unknown."""
        return None if self.inner is None else self.inner.ground_truth()

    @abstractmethod
    def capabilities(self) -> tuple[Capability, ...]:
        """Return the robot's capabilities, one object for each of its actuators and sensors."""

    @abstractmethod
    def step(self) -> None:
        """Let one period pass: commands take effect, and readings become those of the new instant."""

    @abstractmethod
    def stop(self) -> None:
        """Stop the base and hold arm and gripper; commands that were given before the stop are dropped."""

    @abstractmethod
    def close(self) -> None:
        """Release all resources; a second call does nothing."""

    def state(self) -> object | None:
        """Return the state of a simulated world for a checkpoint: plain data that `saved_state.pack` accepts
        (see `plain_values.attributes`).

        None if the world is not simulated, or cannot be saved.
        """
        return None

    def set_state(self, state: object) -> None:
        """Restore the state returned by `state`, in a world built from the same files and seed.

        Raises:
            NotAState: the data belong to another kind of backend.
        """
        raise NotAState(f"the backend {self.name!r} keeps no state")

    def true_base(self) -> Pose2 | None:
        """Return the 2D pose world_T_base of the ground truth; None without ground truth."""
        truth = self.ground_truth()
        return None if truth is None else truth.base

    def figures(self) -> Mapping[str, Any]:
        """Return numbers about the backend for the run's summary, such as the delays of control periods.

        The key of a number is its name, which ends with the unit.
        """
        return {}

    def view(self) -> ByteArray | None:
        """Return a picture of robot and surroundings for videos: RGB (height, width, 3), 0 to 255.

        None if this backend renders only its cameras.
        """
        return None

    def get(self, kind: type[CapabilityT]) -> CapabilityT | None:
        """Return the robot's first capability of the class `kind`; None if the robot has none."""
        return next((capability for capability in self.capabilities() if isinstance(capability, kind)), None)

    def sensor(self, name: str) -> Capability | None:
        """Return the sensor with a name of the robot's file, or None if the robot has no such sensor."""
        return next(
            (capability for capability in self.capabilities() if capability.sensor_name == name), None
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
