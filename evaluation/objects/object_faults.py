"""Faults of objects in a simulated world, which the conformance kit injects into their primitives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
from handcart.primitives.outcomes import causes

HEAVY_KG = 1.2


def _cover_tags(world: Any) -> None:
    """Cover all tags: the print on the sides is not visible any more."""
    for each in world.of(ObjectProps).objects.values():
        each.cover_print()


def _fill(world: Any) -> None:
    """Make all objects heavier than their files say."""
    for each in world.of(ObjectProps).objects.values():
        each.spec = each.spec.model_copy(update={"mass_kg": HEAVY_KG})


OBJECT_FAULTS: Sequence[Fault] = (
    Fault(
        FaultKind.WORLD,
        "the tags are covered",
        act=_cover_tags,
        causes=(causes.NOT_SEEN, causes.AMBIGUOUS, causes.MISPLACED),
    ),
    Fault(
        FaultKind.WORLD,
        "the objects are heavy",
        act=_fill,
        causes=(
            *(causes.NOT_HELD, causes.SLIPPED, causes.OCCUPIED, causes.NO_SUPPORT),
            *(causes.ARM_BLOCKED, causes.NOT_FOLLOWING, causes.MISPLACED),
        ),
    ),
)
