"""Doors and drawers in a world's file."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from handcart.backends.description.things.door_shape import DoorShape
from handcart.backends.simulation.world.world_file import Name, each_once
from handcart.files.models.model import FileModel
from handcart.robotics.manipulation.doors.door_joint import DoorJoint


class SimulatedDoorSpec(DoorShape):
    """True geometry, friction and jams of a simulated door or drawer, which stays where it is left."""

    name: Name
    friction_n: Annotated[float, Field(ge=0.0, le=500.0)] = 5.0
    """Force at the handle that moves it slowly."""
    damping_n_s_m: Annotated[float, Field(ge=0.0, le=1000.0)] = 10.0
    """Additional force for each m/s of the handle's speed, in physics."""
    mass_kg: Annotated[float, Field(gt=0.0, le=200.0)] = 8.0
    locked: bool = False
    """True if the door does not move at all."""
    jams_deg: Annotated[float, Field(gt=0.0, le=180.0)] | None = None
    """Opening of a hinged door beyond which something blocks it."""
    jams_mm: Annotated[float, Field(gt=0.0, le=2000.0)] | None = None
    """Opening of a drawer beyond which something blocks it."""
    grey: Annotated[int, Field(ge=0, le=255)] = 170

    @model_validator(mode="after")
    def _has_radius(self) -> Self:
        if self.is_hinged and self.radius_m is None:
            raise ValueError("a hinged door needs its radius_m; allowed: 0.1 to 3 m")
        return self

    @model_validator(mode="after")
    def _starts_within_its_stop(self) -> Self:
        most = min(self.travel, self.stop)
        if self.opened > most:
            unit, scale = ("deg", math.radians(1.0)) if self.is_hinged else ("mm", 1e-3)
            opened = f"opened_{unit} {self.opened / scale:g}"
            raise ValueError(f"{opened}; allowed: 0 to {most / scale:g} {unit}, where it meets its stop")
        return self

    @property
    def stop(self) -> float:
        """Largest opening that travel, a jam or a lock allows, in [rad], or in [m] for a drawer."""
        if self.locked:
            return self.opened
        jam = self.jams_deg if self.is_hinged else self.jams_mm
        if jam is None:
            return self.travel
        return min(self.travel, math.radians(jam) if self.is_hinged else jam / 1e3)

    @property
    def start(self) -> float:
        """Smallest possible opening, in [rad], or in [m] for a drawer.

        It is 0, or the present opening of a locked door.
        """
        return self.opened if self.locked else 0.0

    def true_joint(self) -> DoorJoint:
        """Return the joint, hinge or slide, on which the door truly moves in the world frame."""
        return self.joint(self.handle.pose, self.radius_m or 1.0)


class DoorsSection(FileModel):
    """Section of a world's file with the doors and drawers, with their true geometry and friction."""

    doors: tuple[SimulatedDoorSpec, ...] = ()

    @model_validator(mode="after")
    def _each_door_once(self) -> Self:
        each_once("door", (door.name for door in self.doors))
        return self
