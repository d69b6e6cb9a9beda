"""What a field has in it: sensors to be laid out, and what measures where they lie."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from handcart.backends.plain_values import Kinds
from handcart.backends.scene.props import Props
from handcart.backends.scene.scene import Scene
from handcart.backends.scene.thing import Rest, Thing

from .magazine import Magazine
from .sensor import Sensor
from .spec import FieldSection


class FieldProps(Props[FieldSection]):
    """Sensors by their numbers, as a magazine gives them to the hand."""

    section = FieldSection
    STATE: ClassVar[Kinds] = {"sensors": dict[str, Sensor], "loaded": int, "in_hand": str}
    BODIES: ClassVar[Mapping[str, str]] = {
        "pybullet": "handcart.backends.pybullet.field.bullet_magazine:BulletMagazine"
    }

    def __init__(self, scene: Scene, spec: FieldSection, seed: int) -> None:
        super().__init__(scene, spec, seed)
        self.sensors: dict[str, Sensor] = {}
        self.loaded = 0
        """How many sensors the magazine has given so far."""
        self.in_hand = ""
        """What the hand held a period ago, by its name."""
        self.total_station = spec.total_station
        """What measures, for evaluation, where the hand is."""
        self.magazine: Magazine | None = None
        if spec.sensors is not None and scene.robot.gripper is not None:
            self.magazine = Magazine(self, spec.sensors)

    def things(self) -> Iterable[Sensor]:
        """See `Props`."""
        return self.sensors.values()

    def step(self) -> None:
        """See `Props`."""
        if self.magazine is not None:
            self.magazine.step()

    def rested(self, thing: Thing) -> None:
        """See `Props`; what is on the robot the magazine has."""
        if thing.rest is not Rest.TRAY:
            super().rested(thing)
