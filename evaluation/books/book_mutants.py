"""Faulty primitives of books, which the conformance kit has to find."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import ClassVar

from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.planted.mutant import (
    Mutant,
    task_violations,
)
from handcart.primitives.books.pick_up import PickUp
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.grip import open_to
from handcart.primitives.preconditions.hand_use import NEEDS_EMPTY
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Trace

RETURN_BOOK_TASK = Path(__file__).parents[2] / "tasks" / "return_book" / "task.yaml"
PICK_UP_NUMBER = 2
"""Number of PICK_UP among the actions of return_book."""


class DropsObject(PickUp):
    """Faulty PICK_UP that, after a failure, opens the hand and so drops the book before the arm returns."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        self._held = False
        yield from open_to(robot, None)
        yield from retrace(robot, start, trace)


class DeniesHold(PickUp):
    """Faulty PICK_UP that reports an empty hand after it took the book."""

    hand: ClassVar = NEEDS_EMPTY


_violations = partial(task_violations, RETURN_BOOK_TASK, "PICK_UP", PICK_UP_NUMBER)
NEEDED_CAPABILITIES = (Arm, Gripper, Camera, RangeSensor)
BOOK_MUTANTS: Sequence[Mutant] = (
    Mutant(
        "DropsObject",
        "opens the hand before it goes back",
        partial(_violations, DropsObject),
        NEEDED_CAPABILITIES,
    ),
    Mutant(
        "DeniesHold",
        "declares an empty hand after it took the book",
        partial(_violations, DeniesHold),
        NEEDED_CAPABILITIES,
        by_truth=True,
    ),
)
