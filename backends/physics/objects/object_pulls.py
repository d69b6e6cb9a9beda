"""Pulls of a person at an object in the hand, in physics."""

from __future__ import annotations

from typing import cast

import numpy as np
from typing_extensions import override

from handcart.backends.physics.props_body import PropsBody
from handcart.backends.simulation.objects.object_props import ObjectProps, carried_off
from handcart.backends.simulation.world.thing import Rest


class ObjectPulls(PropsBody):
    """Simulated person in a physics engine who pulls at the held object.

    When the fingers have released the object, the person carries it away.
    """

    @override
    def step(self) -> None:
        world = self.pieces.world
        for thing in self.props.things():
            if thing.rest is Rest.PERSON:
                pose = carried_off(thing.pose) @ thing.thing_T_middle
                self.pieces.engine.set_pose(world.bodies[thing.name], pose)

    @override
    def act(self) -> None:
        props = cast(ObjectProps, self.props)
        held = props.scene.held
        if held is not None and props.puller.force.any():
            self.pieces.engine.pull(self.pieces.world.bodies[held.name], props.puller.force)

    @override
    def end(self) -> None:
        self.pieces.engine.pull(None, np.zeros(3))
