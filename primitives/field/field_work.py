"""World model section of work in a field."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.files.errors import Finding
from handcart.files.models.loading import load
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.section import Companion, NamedFiles, Section
from handcart.robotics.numerics.arrays import FloatArray

from .field import Field
from .target import Laid, Target
from .target_list import load_targets, place_of


@dataclass
class FieldWork(Section):
    """Part of the world model about a field, with the targets for sensors and the sensors that were laid."""

    LEARNED: ClassVar = ("laid",)

    field: Field | None = None
    """Bounds and known obstacles of the field."""
    targets: Mapping[str, Target] = dataclass_field(default_factory=dict)
    """Targets of the sensors, by name."""
    laid: tuple[Laid, ...] = ()
    """Sensors that were released."""
    listed_in: Path = Path()
    """The file of the targets."""

    @classmethod
    @override
    def load(cls, files: NamedFiles) -> Self:
        ground = files.read("field", lambda path: load(path, Field))
        if "targets" in files.paths and "field" not in files.paths:
            files.wrong("targets", "targets lie in a field; needed: `field`")
        if ground is None:
            return cls()
        targets = files.read("targets", lambda path: load_targets(path, ground, files.start))
        return cls(ground, targets or {}, listed_in=files.paths.get("targets", Path()))

    @override
    def names(self) -> Mapping[str, Collection[object]]:
        return {"targets": list(self.targets)} if self.targets else {}

    def places(self) -> Mapping[str, Place]:
        """Return the place of the base to lay a sensor at each target point of the field, by the target's
        name.
        """
        ground = self.field
        if ground is None:
            return {}
        return {name: place_of(target, ground) for name, target in self.targets.items()}

    @override
    def discs(self) -> FloatArray:
        return np.empty((0, 3)) if self.field is None else self.field.discs

    def faults(self, robot: RobotFile) -> Iterator[Finding]:
        """Yield a finding for each target, a point where a sensor is to be laid, that a rock makes
        unreachable.
        """
        if self.field is None:
            return
        room = robot.footprint_radius_m
        for target in self.targets.values():
            for x, y, radius in self.field.discs.tolist():
                near = math.hypot(target.stand.x - x, target.stand.y - y) - radius
                if near < room or math.hypot(target.x - x, target.y - y) < radius:
                    wrong = (
                        f"the target {target.name!r} can't be reached: the rock at ({x:g}, {y:g}) m leaves"
                    )
                    left = f"{max(near, 0.0):.2f} m for the base beside it; allowed: {room:g} m at least"
                    yield Finding(str(self.listed_in), target.line, target.column, f"{wrong} {left}")

    def companion(self, robot: Robot, place: str) -> Companion | None:
        """Return an arm motion that takes a sensor and holds it over a target while the base drives there;
        None if the place is not that of a target.
        """
        from .on_the_way import SensorOnTheWay

        if self.field is None or place not in self.targets:
            return None
        return SensorOnTheWay(robot, self.field, self.targets[place])

    @override
    def contacts_on_the_way(self, place: str) -> Sequence[MeantContact]:
        return (self.sensor_contact(place),) if place in self.targets else ()

    def sensor_contact(self, target: str) -> MeantContact:
        """Return the intended contact of the hand with the sensor for a target (a point to place a sensor
        at).

        Sensors are taken from the magazine in its order, so that a new target gets the magazine's next
        sensor.
        """
        laid = [item.name for item in self.laid]
        number = laid.index(target) if target in laid else len(laid)
        return MeantContact("hand", f"sensor {number + 1}")

    @override
    def noted(self) -> dict[str, Any]:
        return {
            "sensors_laid": len(self.laid),
            "last_laid": list(self.laid[-1]) if self.laid else None,
        }
