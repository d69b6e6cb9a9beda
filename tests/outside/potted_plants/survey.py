"""Ground truth of watering."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
from handcart.evaluation.judging.survey import Claim, Effect, Survey

from .knowledge import Plants
from .props import Pots

OFF_ML = 25.0  # that a plant may get more or less than it needs


def _watered(survey: Survey, claim: Claim) -> list[str]:
    name, garden = claim.primitive.plant, survey.run.model.of(Plants).garden
    got = survey.run.world.of(Pots).pots[name].level_ml
    needs = garden.plants[name].needs_ml if garden else 0.0
    return [] if abs(got - needs) <= OFF_ML else [f"{name} got {got:.0f} ml, needs {needs:.0f}"]


class Watering(Survey):
    """Amounts of water that each plant got, and that were spilt."""

    name = "plants"
    effects: ClassVar[Mapping[str, Effect]] = {"WATER": _watered}

    def figures(self) -> Mapping[str, Any]:
        garden = self.run.world.of(Pots)
        levels = {f"{name}_ml": pot.level_ml for name, pot in garden.pots.items()}
        return {name: round(ml, 1) for name, ml in {**levels, "spilt_ml": garden.spilt_ml}.items()}


def _leak(world: Any) -> None:
    for can in world.of(Pots).cans.values():
        can.level_ml = 0.0


FAULTS: Sequence[Fault] = (Fault(FaultKind.WORLD, "the can is empty", act=_leak),)
