"""Primitives that begin with the recognized book in the hand."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.tree_primitive import TreePrimitive
from handcart.primitives.knowledge.world_model import ModelView

from .book_grip import book_in, unlike_book


class HeldBookPrimitive(TreePrimitive):
    """Base class of primitives that move the book in the hand; a behaviour tree controls the motion.

    At the start, the hand must hold the book that was recognized before.
    """

    @override
    def thing(self, model: ModelView) -> str:
        return book_in(model)

    @override
    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        return unlike_book(robot, model)
