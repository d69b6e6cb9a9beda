"""The parts of a robot, by their kinds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability

from .skipped import Skipped

CapabilityT = TypeVar("CapabilityT", bound=Capability)


def part_of(backend: Backend, kind: Callable[..., CapabilityT]) -> CapabilityT | None:
    """Return a backend's capability, such as its base, by its class; None if the robot lacks it.

    Unlike in `Backend.get`, type checkers accept an abstract class.
    """
    return backend.get(cast("type[CapabilityT]", kind))


def needed(backend: Backend, kind: Callable[..., CapabilityT]) -> CapabilityT:
    """Return a backend's capability by its class; raises `Skipped` if the robot lacks the capability."""
    part = part_of(backend, kind)
    if part is None:
        raise Skipped(f"the robot has no {cast('type[CapabilityT]', kind).words()}")
    return part
