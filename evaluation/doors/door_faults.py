"""Faults of doors in a simulated world, which the conformance kit injects into their primitives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from handcart.backends.simulation.doors.door_props import DoorProps
from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
from handcart.primitives.outcomes import causes

STICKING_N = 120.0


def _cover_tags(world: Any) -> None:
    """Cover all tags: the print on the fronts is not visible any more."""
    for part in world.of(DoorProps).parts.values():
        part.cover_print()


def _stick(world: Any) -> None:
    """Let all doors stick where they are; physics engines keep their joints as they were built."""
    for part in world.of(DoorProps).parts.values():
        if part.spec.friction_n != STICKING_N:
            part.spec = part.spec.model_copy(update={"friction_n": STICKING_N})


DOOR_FAULTS: Sequence[Fault] = (
    Fault(
        FaultKind.WORLD,
        "the tags of the doors are covered",
        act=_cover_tags,
        causes=(causes.NOT_SEEN, causes.MISPLACED),
    ),
    Fault(
        FaultKind.WORLD,
        "the doors stick",
        act=_stick,
        causes=(causes.ARM_BLOCKED, causes.NOT_FOLLOWING, causes.MISPLACED, causes.SLIPPED),
    ),
)
