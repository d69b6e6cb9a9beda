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
    """Parts of a physics simulation (engine, robot, world, gripper and grip) that a `PropsBody` needs, which
    simulates the objects of one kind of task.
    """

    engine: Engine
    body: RobotBody
    world: WorldBodies
    gripper: PhysicsGripper | None
    grip: Grip | None


class PropsBody:
    """Base class of the physics of a domain's objects (props) beyond rigid bodies, such as a pulling person.

    A domain names its subclass in `Domain.physics`. The methods of this class do nothing.
    """

    STATE: ClassVar[Kinds] = {}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, props: SceneProps, pieces: Pieces) -> None:
        self.props, self.pieces = props, pieces

    def step(self) -> None:
        """Act on the objects of one domain (kind of task) at the beginning of a period, after the scene has
        moved them.
        """

    def act(self) -> None:
        """Update the simulation of this domain's objects before each chunk of a period; a chunk is the time
        between two commands to the drives.
        """

    def end(self) -> None:
        """Update the simulation of this domain's objects at the end of a control period, before the poses of
        things are read from the physics engine.
        """

    @property
    def keeps_grip(self) -> bool:
        """True if the hand counts as holding its object now, even if the fingers do not press on the object.
        By default it does not.
        """
        return False
