"""The magazine of a robot in physics."""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from handcart.backends.physics.props_body import Pieces, PropsBody
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.backends.simulation.field.sensor import Sensor
from handcart.backends.simulation.world.thing import Rest

HOLDING_GAP_M = 0.0005  # [m] between fingers and sensor, from where on they hold it
PRESSING_PERIODS = 8  # periods that they get to press on it


class Magazine(PropsBody):
    """Magazine on the robot in a physics engine, which holds the next sensor to be laid between the open
    fingers.

    The sensor collides with nothing until the fingers have closed on it.
    """

    STATE: ClassVar[Kinds] = {"_given": int}

    def __init__(self, props: FieldProps, pieces: Pieces) -> None:
        super().__init__(props, pieces)
        self._field = props
        self._given = PRESSING_PERIODS

    @property
    def keeps_grip(self) -> bool:
        """True for 8 periods after the hand took a sensor, in which the fingers do not have to press on it
        yet.
        """
        return self._given < PRESSING_PERIODS

    @override
    def step(self) -> None:
        self._given += 1
        sensor, (engine, _, world, gripper, grip) = self._waiting(), self.pieces
        if sensor is None or gripper is None or grip is None:
            return
        body = world.bodies[sensor.name]
        closed = not gripper.opening and gripper.true_width() < sensor.size[1] + HOLDING_GAP_M
        engine.touches(body, closed)
        if closed:
            self.act()
            grip.take(body)
            sensor.rest, self._given = Rest.HAND, 0

    def act(self) -> None:
        """Keep the sensor that will be laid next at its place in the magazine while the robot moves."""
        sensor, (engine, body, world, *_) = self._waiting(), self.pieces
        if sensor is not None and sensor.name in world.bodies:
            pose = body.base_pose() @ sensor.base_T_thing @ sensor.thing_T_middle
            engine.set_pose(world.bodies[sensor.name], pose)

    def end(self) -> None:
        """Put the sensor that is to be laid next back at its place in the magazine, if the engine simulates a
        period in one piece.

        In such a period the sensor falls a little, because nothing holds it between the steps of the engine.
        """
        if self.pieces.engine.chunks == 1:
            self.act()

    def _waiting(self) -> Sensor | None:
        return self._field.waiting()
