"""The base class of all backends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TypeVar

from files.errors import HandcartError

from .capability import Capability
from .robot_file import RobotFile

C = TypeVar("C", bound=Capability)


class CommandError(HandcartError, ValueError):
    """A command that no robot may be given: not finite, or beyond a limit that its file states."""


class Backend(ABC):
    """Something that behaves like a robot: a stub, a simulator, or hardware.

    It gives raw readings as hardware would, with the hardware's errors; what follows from them is computed
    above it, by `Robot`, the same for all. A context manager: leaving it closes the backend.
    """

    name: str
    """How `--backend` calls it."""
    period: float
    """The control period, in [s]."""

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

    def get(self, kind: type[C]) -> C | None:
        """The capability of that kind, None where the robot has none."""
        return next((each for each in self.capabilities() if isinstance(each, kind)), None)

    def __enter__(self) -> Backend:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
