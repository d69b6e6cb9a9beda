"""Actions of a domain's props in physics."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

from handcart.backends.physics.body.grip import Grip
from handcart.backends.physics.body.physics_gripper import PhysicsGripper
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.world.world_bodies import WorldBodies
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.world.scene_props import SceneProps


class Pieces(NamedTuple):
    """Parts of a physics simulation that a domain's props may act on."""

    engine: Engine
    body: RobotBody
    world: WorldBodies
    gripper: PhysicsGripper | None
    grip: Grip | None


class PropsBody:
    """Physics of a domain's props, named by `Domain.physics`; by default it does nothing."""

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, props: SceneProps, pieces: Pieces) -> None:
        self.props, self.pieces = props, pieces

    def step(self) -> None:
        """Begin a period, after `Props.step`."""

    def act(self) -> None:
        """Act before each chunk of the period, which is the time between two actions of the drives."""

    def end(self) -> None:
        """Act at the end of a period, before things are located."""

    @property
    def keeps_grip(self) -> bool:
        """Return whether the hand keeps its object although the fingers don't press on it."""
        return False
