"""The base class of all backends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeVar

from files.errors import HandcartError

from .capability import Capability

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
