"""Pots and a can in simulated worlds: water runs from the one into the others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.placed_thing import PlacedSpec, PlacedThing
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.thing import GreyImage, Side
from handcart.files.models.model import FileModel
from handcart.robotics.geometry.transform import inverse

POURS = np.radians(45.0)  # beyond that tilt water runs over the rim
FLOW = 25.0  # [ml/s]


class VesselSpec(PlacedSpec):
    """A pot or a can."""

    level_ml: float = 0.0


class GardenSection(FileModel):
    """Keys of a world's file."""

    pots: tuple[VesselSpec, ...] = ()
    cans: tuple[VesselSpec, ...] = ()


@dataclass(eq=False, repr=False)
class Vessel(PlacedThing):
    """The more water, the brighter it is from above, and the heavier."""

    KIND, WEIGHS = "vessel", True

    spec: VesselSpec
    level_ml: float = 0.0

    @property
    def mass(self) -> float:
        return 0.05 + self.level_ml / 1e3

    def faces(self) -> Mapping[Side, GreyImage]:
        return {"+z": np.full((16, 16), min(255, 20 + round(self.level_ml)), np.uint8)}

    def rim(self) -> NDArray[np.float64]:
        """Point over which water runs out, (3,) in [m] in the world: the lowest side of its upper rim."""
        sides = np.array([(0.5, 0, 1, 1), (-0.5, 0, 1, 1), (0, 0.5, 1, 1), (0, -0.5, 1, 1)])
        rim = (sides * (*self.size, 1.0)) @ self.pose.T
        return np.asarray(rim[np.argmin(rim[:, 2]), :3])


class Pots(Props[GardenSection]):
    """Pots by name, and a can."""

    section = GardenSection
    STATE: ClassVar[Kinds] = {"pots": dict[str, Vessel], "cans": dict[str, Vessel], "spilt_ml": float}

    def set_up(self) -> None:
        self.pots, self.cans = map(self._placed, (self.spec.pots, self.spec.cans))
        self.spilt_ml = 0.0

    def _placed(self, specs: Iterable[VesselSpec]) -> dict[str, Vessel]:
        place = Vessel.set_down
        return {spec.name: place(self.scene, spec, self.seed, level_ml=spec.level_ml) for spec in specs}

    def things(self) -> Iterable[Vessel]:
        return [*self.pots.values(), *self.cans.values()]

    def step(self) -> None:
        for can in self.cans.values():
            runs = min(can.level_ml, FLOW * self.scene.robot.period_s) if can.tilt() > POURS else 0.0
            can.level_ml -= runs
            self.spilt_ml += runs
            for pot in self.pots.values():
                x, y, z, _ = inverse(pot.pose) @ (*can.rim(), 1.0)
                if abs(x) < pot.size[0] / 2 and abs(y) < pot.size[1] / 2 and z > 0.0:
                    pot.level_ml += runs
                    self.spilt_ml -= runs
