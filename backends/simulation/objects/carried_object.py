"""A box or cylinder with printed tags, as a solid body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from typing_extensions import override

from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.world.placed_thing import PlacedSpec, PlacedThing
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import GreyImage, Side

from .printed_thing import PrintedThing
from .spec import CarriedObjectSpec
from .tag_print import printed_faces


@dataclass(eq=False, repr=False)
class CarriedObject(PlacedThing, PrintedThing):
    """Box or cylinder that the robot can carry, with its true pose in the simulated world.

    Its frame: origin in the middle of its underside; x, y and z along its length, width and height.
    """

    KIND = "object"
    WEIGHS = True

    spec: CarriedObjectSpec

    @property
    @override
    def is_round(self) -> bool:
        return self.spec.shape == "cylinder"

    @property
    @override
    def mass(self) -> float:
        return self.spec.mass_kg

    @override
    @classmethod
    def set_down(cls, scene: Scene, spec: PlacedSpec, seed: int, **others: Any) -> Self:
        """Return an object at the pose of its spec, with random errors of the person who sets it down.

        Args:
            scene: scene with the robot in place, whose file has the standard deviations of a person's errors.
            spec: the object and its nominal pose; errors with the object's own standard deviations are added.
            seed: seed of the errors.
            others: values of further fields of the class, by name.
        """
        assert isinstance(spec, CarriedObjectSpec)
        dx, dy, turn = keyed(seed, f"place of {cls.KIND} {spec.name}").standard_normal(3).tolist()
        placed = spec.model_copy(
            update={
                "x_m": spec.x_m + spec.sigma_mm / 1e3 * dx,
                "y_m": spec.y_m + spec.sigma_mm / 1e3 * dy,
                "heading_deg": spec.heading_deg + spec.sigma_deg * turn,
            }
        )
        return super().set_down(scene, placed, seed, **others)

    @override
    def draw_faces(self) -> Mapping[Side, GreyImage]:
        return printed_faces(self.spec.tags, self.spec.size_mm, self.spec.grey)
