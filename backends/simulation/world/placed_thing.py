"""A box that a person sets down before a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field
from typing_extensions import override

from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.geometry.transform import transform

from .scene import Scene
from .thing import Rest, Thing
from .world_file import FloorPose, Millimetres, Name


class PlacedSpec(FloorPose):
    """Size of a thing, and the pose of the middle of its underside where a person sets it down
    before a run.
    """

    name: Name
    on: Literal["world", "robot"] = "world"
    """Frame of its place, the world's or, for a thing on the robot's own table, the base's."""
    height_m: Annotated[float, Field(ge=0.0, le=3.0)]
    """Height of its foot."""
    size_mm: tuple[Millimetres, Millimetres, Millimetres] = (25.0, 80.0, 40.0)
    """Length, width and height, along its x, y and z."""
    grey: Annotated[int, Field(ge=0, le=255)] = 190


@dataclass(eq=False, repr=False)
class PlacedThing(Thing):
    """Box that a person sets down before a run.

    The origin of its frame is in the middle of its bottom face; x points along its length, z up.
    """

    KIND: ClassVar[str] = "thing"
    """Prefix of its name, before the name in the world's file."""

    spec: PlacedSpec

    @property
    @override
    def name(self) -> str:
        return f"{self.KIND} {self.spec.name}"

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width, height along x, y, z of its frame, in [m]."""
        length, width, height = self.spec.size_mm
        return length / 1e3, width / 1e3, height / 1e3

    @property
    @override
    def grey(self) -> int:
        return self.spec.grey

    @classmethod
    def set_down(cls, scene: Scene, spec: PlacedSpec, seed: int, **others: Any) -> Self:
        """Return a thing that a person sets down on a table or the robot's tray, with small random errors.

        Args:
            scene: scene with the robot in place, whose file has the standard deviations of the errors.
            spec: the thing, and its nominal pose.
            seed: seed of the errors.
            others: values of further fields of the class, by name.
        """
        errors = scene.robot.errors
        dx, dy, turn = keyed(seed, f"{cls.KIND} {spec.name}").standard_normal(3)
        place = errors.block_place_mm / 1e3
        yaw = np.radians(spec.heading_deg + errors.block_turn_deg * turn)
        stands = transform((spec.x_m + place * dx, spec.y_m + place * dy, spec.height_m), (0.0, 0.0, yaw))
        scene.changes += 1
        if spec.on == "robot":
            return cls(scene.world_T_base @ stands, Rest.TRAY, spec, base_T_thing=stands, **others)
        return cls(stands, Rest.TABLE, spec, **others)
