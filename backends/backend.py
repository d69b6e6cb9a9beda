"""The base class of all backends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import HandcartError, InputError
from handcart.robotics.geometry.pose2 import Pose2

from .ground_truth import GroundTruth
from .recording import Recording
from .saved_state import NotAState

C = TypeVar("C", bound=Capability)


class CommandError(HandcartError, ValueError):
    """A command that no robot may be given: not finite, or beyond a limit that its file states."""


class RobotFault(HandcartError):
    """The robot can't be driven any more: it has been stopped, and a person has to look."""

    exit_status = 4


class NoBench(InputError):
    """Simulated drives were asked for where there are no drives."""


class NotMovable(InputError):
    """A backend cannot put its robot elsewhere than the world's file says."""


class NoWindow(InputError):
    """A window was asked for where there is none."""


class Backend(ABC):
    """Something that behaves like a robot: a stub, a simulator, or hardware.

    It gives raw readings as hardware would, with the hardware's errors; what follows from them is computed
    above it, by `Robot`, the same for all. A context manager: leaving it closes the backend.
    """

    name: str
    """How `--backend` calls it."""
    period: float
    """The control period, in [s]."""
    has_drives: ClassVar[bool] = False
    """Whether simulated drives can be put before a simulated backend; see `build_on_bench`."""
    simulated: bool = True
    """Whether the world behind it is made anew by `build`; a real one stands as it was left."""
    address: str = ""
    """Which robot it is, where several of its kind are in reach of this machine, such as `socketcan can0`."""
    remarks: Sequence[str] = ()
    """What of the robot isn't as its files say, in words; told before a run."""
    recording: Recording | None = None
    """Keeps what passes between program and robot beside the journal; None where there is nothing to keep."""

    @classmethod
    @abstractmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """From a robot's file.

        Args:
            robot: what it is to behave like.
            world: the file of what stands around it; simulated backends need one, others don't look at it.
            seed: of simulated errors.

        Raises:
            FileError: the world's file is missing or something in it is wrong.
        """

    @classmethod
    def read_world(cls, path: Path, start: Pose2) -> Any:
        """What `build` takes in place of a world's file, or of a map on which the robot is at `start`.

        None where it reads the file itself: then it gets a world's file in place of a map.

        Raises:
            FileError: the file is missing or something in it is wrong.
        """
        return None

    @classmethod
    def with_start(cls, world: Any, start: Pose2) -> Any:
        """Return what `read_world` gave, with the robot at `start` (world_T_base) at first.

        Raises:
            NotMovable: the backend cannot put its robot there.
        """
        raise NotMovable(
            f"the backend {cls.name!r} cannot put its robot at a given place; "
            "allowed: no start place, or a simulated backend of handcart"
        )

    @classmethod
    def build_in_window(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        """As `build`, and robot and world are shown in a window.

        Raises:
            NoWindow: this backend has none, or there is no display.
        """
        raise NoWindow(
            f"the backend {cls.name!r} has no window; allowed: a video of the run, --video FILE.mp4"
        )

    @classmethod
    def kinds(cls, robot: RobotFile) -> tuple[type[Capability], ...] | None:
        """What the robot could do, by its file alone: nothing is opened, and no robot is spoken to.

        None where that is found out by building it; then `handcart check` builds one. A backend whose
        building reaches a real robot must tell.

        Raises:
            InputError: such a robot can't be built.
        """
        return None

    @classmethod
    def build_on_bench(cls, robot: RobotFile, world: Path | None, seed: int, bench: type[Backend]) -> Backend:
        """As `build`, with simulated drives in front of a simulated backend.

        Raises:
            NoBench: this backend has no drives, or there can be no such bench.
        """
        raise NoBench(f"the backend {cls.name!r} has no drives; allowed: --bench with --backend can")

    @property
    def inner(self) -> Backend | None:
        """What this backend is put around, where it stands before another one."""
        return None

    def ground_truth(self) -> GroundTruth | None:
        """How robot and world truly stand now, for evaluation alone; None where nobody can know."""
        return None if self.inner is None else self.inner.ground_truth()

    @abstractmethod
    def capabilities(self) -> tuple[Capability, ...]:
        """What the robot behind it can do."""

    @abstractmethod
    def step(self) -> None:
        """Let one period pass: commands take effect, and readings become those of the new instant."""

    @abstractmethod
    def stop(self) -> None:
        """Stop all motion; arm and gripper hold. Nothing that was commanded before moves the robot after."""

    @abstractmethod
    def close(self) -> None:
        """Let go of everything. A second call does nothing."""

    def state(self) -> object | None:
        """Where a simulated world stands, for a checkpoint: plain data that `saved_state.pack` takes (see
        `plain_values.attributes`).

        None where the world is no simulation, or can't be kept.
        """
        return None

    def set_state(self, state: object) -> None:
        """Put a world, built anew from the same files and seed, where `state` was taken.

        Raises:
            NotAState: it is of something else.
        """
        raise NotAState(f"the backend {self.name!r} keeps no state")

    def true_base(self) -> Pose2 | None:
        """world_T_base of the ground truth alone; None where there is none."""
        truth = self.ground_truth()
        return None if truth is None else truth.base

    def figures(self) -> Mapping[str, Any]:
        """Figures for the run's summary, such as how late periods were; by name, with the unit at its end."""
        return {}

    def view(self) -> NDArray[np.uint8] | None:
        """Robot and surroundings as somebody beside them sees them, for videos: RGB (height, width, 3).

        None where this backend renders nothing but its cameras.
        """
        return None

    def get(self, kind: type[C]) -> C | None:
        """The capability of that kind, None where the robot has none."""
        return next((each for each in self.capabilities() if isinstance(each, kind)), None)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
