"""What somebody else's package has in simulated worlds: pots whose water dries up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from handcart.backends.plain_values import Kinds
from handcart.backends.scene.placed_thing import PlacedSpec, PlacedThing
from handcart.backends.scene.props import Props
from handcart.backends.scene.thing import GreyImage, Side
from handcart.files.model import FileModel

DRIES = 0.1  # [ml] in a period


class PotSpec(PlacedSpec):
    """A pot with water in it."""

    level_ml: float = 100.0


class PotsSection(FileModel):
    """Keys of a world's file that are about pots."""

    pots: tuple[PotSpec, ...] = ()


@dataclass(eq=False, repr=False)
class Pot(PlacedThing):
    """The more water, the brighter it is from above."""

    KIND = "pot"
    WEIGHS = True

    spec: PotSpec
    level_ml: float = 0.0

    @property
    def mass(self) -> float:
        return super().mass + self.level_ml / 1e3

    def faces(self) -> Mapping[Side, GreyImage]:
        return {"+z": np.full((32, 32), 20 + 2 * round(self.level_ml), np.uint8)}


class Pots(Props[PotsSection]):
    """Pots by name."""

    section = PotsSection
    STATE: ClassVar[Kinds] = {"pots": dict[str, Pot]}

    def set_up(self) -> None:
        self.pots = {
            spec.name: Pot.set_down(self.scene, spec, self.seed, level_ml=spec.level_ml)
            for spec in self.spec.pots
        }

    def things(self) -> Iterable[Pot]:
        return self.pots.values()

    def step(self) -> None:
        for pot in self.pots.values():
            pot.level_ml = max(0.0, pot.level_ml - DRIES)
