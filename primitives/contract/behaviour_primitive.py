"""Wrap a py_trees behaviour as a primitive."""

from __future__ import annotations

from collections.abc import Callable

from py_trees.behaviour import Behaviour

from handcart.backends.capabilities.capability import Capability
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView

from .tree_primitive import TreePrimitive


def behaviour_primitive(
    name: str,
    make: Callable[[Robot, ModelView], Behaviour],
    needs: tuple[type[Capability], ...] = (),
    reads: tuple[str, ...] = (),
    writes: tuple[str, ...] = (),
) -> type[TreePrimitive]:
    """Return a primitive class whose motion is a given behaviour or behaviour tree of py_trees.

    To restore, it plays the recorded motion backwards. An entry point of the group `handcart.primitives`
    makes the class available in task files.

    Args:
        name: name of the class, in CamelCase; `WaterPlants` is WATER_PLANTS in task files.
        make: function that makes a new behaviour for each attempt. The behaviour commands the robot in its
            method `update`, once a period, and never steps it.
        needs: capabilities that the primitive needs.
        reads: entries of the world model that the primitive reads.
        writes: entries of the world model that the primitive writes.
    """

    def tree(self: TreePrimitive, robot: Robot, model: ModelView) -> Behaviour:
        return make(robot, model)

    body = {
        "__doc__": f"The behaviour {name} as a primitive.",
        "__module__": make.__module__,
        "tree": tree,
        "needs": needs,
        "reads": reads,
        "writes": writes,
    }
    return type(name, (TreePrimitive,), body)
