"""The person who hands books over."""

from __future__ import annotations

from typing import ClassVar

from handcart.robotics.geometry.pose2 import Pose2

from .scene import Scene, set_on_tray

NEAR = 0.5  # [m] from where the robot started, within a person's reach
STILL = 1e-3  # [m], [rad]: motors that hold a robot still let it move less
AFTER = 1.0  # [s] that the robot stands there with an empty tray and hand before the next book comes


class Person:
    """Puts the next book onto the robot's tray when it stands at its start again, tray and hand empty."""

    STATE: ClassVar = {"_given": int, "_stood": Pose2, "_since": float}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, scene: Scene, seed: int) -> None:
        """Hand over the books in `scene.to_come`; `seed` is that of how they are put down."""
        self._scene = scene
        self._seed = seed
        self._start = scene.base
        self._given = 0
        self._stood = Pose2(0.0, 0.0, 0.0)
        self._since = 0.0

    def step(self) -> None:
        """One period passes."""
        scene = self._scene
        if not scene.to_come or not scene.robot.has_tray:
            return
        idle = scene.held is None and scene.tray_book() is None
        stands = scene.base.distance(self._stood) < STILL and scene.base.turn(self._stood) < STILL
        if not (idle and stands) or scene.base.distance(self._start) > NEAR:
            self._stood, self._since = scene.base, scene.time
        elif scene.time >= self._since + AFTER:
            self._given += 1
            set_on_tray(scene, scene.to_come.pop(0), self._seed, self._given)
