"""Lifting a held object out from between others that were not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model, follow
from handcart.primitives.objects.site.object_site import surroundings
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.numerics.arrays import FloatArray

RISE_STEP_M = 0.02
MAX_RISE_M = 0.36  # over the height of what stands beside an object


def lift_clear(robot: Robot, model: ModelView, held: Solid, beside: Sequence[Solid] = ()) -> Periods:
    """Lift the held object straight up until it is clear of the assumed places of objects that were not seen.

    Objects that were next to the held object on its surface are not above it, so a straight lift is free.
    Nothing moves if the object is clear already, or if the arm can't lift it that far. If it can't be lifted
    clear of the bodies `beside`, it is lifted clear of the others.

    Args:
        robot: robot whose hand holds an object that was lifted off its surface.
        model: world model with surfaces and objects.
        held: the held object, posed in the hand frame.
        beside: further bodies to be above in the end, in the base frame, such as the held object at its old
            place: others like it may be beside it.
    """
    around, here = surroundings(robot, model), robot.arm.command()
    sure = collision_model(robot, held, surroundings(robot, model, believed=False))
    for bodies in ((*around, *beside), around):
        every = collision_model(robot, held, bodies)
        if not every.in_collision(here):
            return
        path = yield from robot.compute(path_up, every, sure, here)
        if path is not None:
            yield from follow(robot, path)
            return


def path_up(every: CollisionModel, sure: CollisionModel, here: FloatArray) -> FloatArray | None:
    """Return a path of the arm straight up, until it is clear of all bodies; None if no path is found.

    Args:
        every: collision model with all bodies to keep clear of at the end.
        sure: collision model with only the bodies to keep clear of on the path.
        here: (n,) joints at the start, in [rad] or [m].

    Returns:
        Joint positions (m, n), in [rad] or [m].
    """
    goal = sure.arm.forward(here)
    lines = [here[np.newaxis]]
    for _ in range(round(MAX_RISE_M / RISE_STEP_M)):
        goal[2, 3] += RISE_STEP_M
        line = plan_straight(sure.arm, lines[-1][-1], goal, collision=sure)
        if line is None:
            return None
        lines.append(line[1:])
        if not every.in_collision(line[-1]):
            return np.vstack(lines)
    return None
