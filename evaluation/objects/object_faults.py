"""Faults of objects in a simulated world, which the conformance kit injects into their primitives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.backends.simulation.objects.pull_spec import PullSpec
from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
from handcart.primitives.objects.knowledge import object_causes
from handcart.primitives.outcomes import causes

HEAVY_KG = 1.2
PULL_SPEC = PullSpec(at_s=0.0, force_n=15.0, tremor_n=1.0, duration_s=2.0)
TEAR_SPEC = PullSpec(at_s=0.0, force_n=300.0, ramp_s=1.0, duration_s=2.0)
BUMP_SPEC = PullSpec(at_s=0.0, force_n=30.0, direction="left", ramp_s=0.0, duration_s=0.15, takes=False)
PULL_CAUSES = (
    *(object_causes.PULLED, causes.ARM_BLOCKED, causes.NOT_FOLLOWING, causes.OCCUPIED, causes.NO_SUPPORT),
    *(causes.NOT_HELD, causes.SLIPPED, causes.MISPLACED, causes.NOT_SEEN, causes.DISPLACED, causes.NO_REST),
    *(causes.FINGERS_STUCK, causes.NO_EFFECT),
)


def _cover_tags(world: Any) -> None:
    """Cover all tags: the print on the sides is not visible any more."""
    for object_ in world.of(ObjectProps).objects.values():
        object_.cover_print()


def _fill(world: Any) -> None:
    """Make all objects heavier than their files say."""
    for object_ in world.of(ObjectProps).objects.values():
        object_.spec = object_.spec.model_copy(update={"mass_kg": HEAVY_KG})


def _pulls(spec: PullSpec) -> Callable[[Any], None]:
    """Return a function that lets a person pull at the object in the hand."""
    return lambda world: world.of(ObjectProps).pull_now(spec)


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
    Fault(FaultKind.WORLD, "a person pulls", act=_pulls(PULL_SPEC), causes=PULL_CAUSES),
    Fault(FaultKind.WORLD, "a person tears it out", act=_pulls(TEAR_SPEC), causes=PULL_CAUSES),
    Fault(FaultKind.WORLD, "somebody bumps into it", act=_pulls(BUMP_SPEC), causes=PULL_CAUSES),
)
