"""The magazine of a robot in physics."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.scene.block import Block
from handcart.backends.scene.magazine import Magazine
from handcart.backends.scene.thing import Rest

from .bullet_gripper import BulletGripper
from .grip import Grip
from .physics import Physics
from .robot_body import RobotBody
from .world_bodies import WorldBodies

CLOSED = 0.0005  # [m] between fingers and sensor, from where on they hold it
FRESH = 8  # periods that they get to press on it


class BulletMagazine:
    """Holds the next sensor between the open fingers until they close on it; till then it touches nothing."""

    STATE: ClassVar = {"_given": int}

    def __init__(
        self,
        magazine: Magazine,
        body: RobotBody,
        world: WorldBodies,
        physics: Physics,
        gripper: BulletGripper,
        grip: Grip,
    ) -> None:
        self._scene, self._body, self._world, self._physics = magazine.scene, body, world, physics
        self._gripper, self._grip = gripper, grip
        self._magazine, self._wide = magazine, magazine.spec.size_mm[1] / 1e3
        self._given = FRESH

    @property
    def fresh(self) -> bool:
        """Whether the fingers have just been given a sensor, and needn't press on it yet."""
        return self._given < FRESH

    def step(self) -> None:
        """A period begins."""
        self._given += 1
        self._magazine.step()
        sensor = self._waiting()
        if sensor is None:
            return
        if sensor.name not in self._world.bodies:
            self._world.add(sensor)
        body = self._world.bodies[sensor.name]
        closed = self._gripper.true_width() < self._wide + CLOSED
        self._physics.touches(body, closed)
        if closed:
            self.hold()
            self._grip.take(body)
            sensor.rest, self._given = Rest.HAND, 0

    def hold(self) -> None:
        """Keep what waits where it is on the robot, however the robot moves; asked each chunk."""
        sensor = self._waiting()
        if sensor is not None and sensor.name in self._world.bodies:
            pose = self._body.base_pose() @ sensor.base_T_block @ sensor.thing_T_middle
            self._physics.set_pose(self._world.bodies[sensor.name], pose)

    def _waiting(self) -> Block | None:
        sensor = self._scene.blocks.get(str(self._scene.loaded))
        return sensor if sensor is not None and sensor.rest is Rest.TRAY else None
