"""INSERT: push the held book into its slot."""

from __future__ import annotations

import math
from collections.abc import Generator
from collections.abc import Sequence as Several
from functools import partial
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence
from pydantic import PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.books import book_causes
from handcart.primitives.books.book_boxes import held_box
from handcart.primitives.books.book_grip import hand_to_spine, holds, opening, watch_grip
from handcart.primitives.books.books import Books
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.tree_primitive import Step, leaves
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight, move_to_joints
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.grip import hand_to_tips
from handcart.primitives.motions.pushing import Pushed, push, relax
from handcart.primitives.motions.taught import taught_postures
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured, NeedsPerson
from handcart.primitives.outcomes.exceeds import exceeds
from handcart.primitives.preconditions.hand_use import CARRIES_OBJECT
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box

from .book_row import row_contacts
from .held_book import HeldBookPrimitive
from .shelf_front import measure_shelf

TIPS_BEFORE = 0.007  # [m] from the finger tips to the shelf's front: spines reach 3 mm beyond it
INSERT_SPEED_M_S = 0.02
JAM_FORCE_N = 7.0  # sliding in takes 2
PUSHES_BACK = 10.0  # [N]: a neighbour gives way from here on, and the hand's camera doesn't see it
STRAIGHT_PUSH = "straight"
PUSH_OFFSETS = {
    STRAIGHT_PUSH: (0.0, 0.0),
    "a little further left, turned left": (0.003, 0.035),
    "a little further right, turned right": (-0.003, -0.035),
}
"""Offsets of the pushes to try, each a shift to the left in [m] and a turn to the left in [rad]."""
SIDE_FORCE = 1.5  # [N] from the slot's sides that the hand yields to
ASIDE, MOST_ASIDE = 0.0005, 0.008  # [m]: a step, and how far the hand yields at most
PUSH_END_TOLERANCE_M = 0.004


class _Course(NamedTuple):
    """Insertion geometry, measured once before the first push."""

    start: Transform
    """base_T_hand (4, 4)."""
    end: Transform
    """base_T_hand (4, 4) at the end; in the slot the hand yields sideways."""
    edge: float
    """Distance from the hand to the book's leading edge, in [m]."""
    held: Box
    """The book, in the hand's frame."""


class Insert(HeldBookPrimitive):
    """Push the held book straight into its slot, until the finger tips are just before the spines.

    The push begins where the primitive APPROACH has left the book; its length is measured at the shelf's
    front. A book that jams is pulled out and pushed again a few millimetres to the side. If it jams
    everywhere, it is pulled back to the start, and the action Fails. No sensor shows whether a neighbour was
    pushed back, so that the action gives up instead if it has pushed with more than 10 N. With the method
    `taught`, the hand plays back the postures `insert_1`, `insert_2` and so on, and ignores the lidar.
    """

    shelf: PlaceName
    """The place before the shelf."""
    method: Literal["planned", "taught"] = "planned"
    """Source of the hand's motion."""
    wiggle: bool = True
    """Try a book that jams again, a little to the side."""

    needs: ClassVar = (Arm, Gripper, RangeSensor)
    reads: ClassVar = ("places", "book")
    hand: ClassVar = CARRIES_OBJECT

    _course: _Course = PrivateAttr()
    _base_T_end: Transform | None = PrivateAttr(default=None)
    """base_T_hand (4, 4) where the push ends, once the book is in the slot."""
    _resists: float = PrivateAttr(default=0.0)
    """Force that resisted the last push, in [N]."""
    _strongest: float = PrivateAttr(default=0.0)

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        """Return the behaviour tree that inserts the book: preparing steps, then pushes until
        one succeeds.
        """
        begin = {
            "measure how far it goes": lambda: self._measure(robot, model),
            "note what is about to be done": lambda: self.intend("the book is pushed between its neighbours"),
        }
        ways = PUSH_OFFSETS if self.wiggle and self.method == "planned" else (STRAIGHT_PUSH,)
        tries: dict[str, Step] = {
            way: partial(self._try, robot, way, number) for number, way in enumerate(ways, start=1)
        }
        pushing = leaves(tries | {"say that it jams": self._say_that_it_jams})
        push_in = Selector("push it in, one way or another", memory=True, children=pushing)
        return Sequence("insert the book", memory=True, children=[*leaves(begin), push_in])

    def _measure(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        if books.book is None or not holds(robot, books.book):
            raise Discrepancy(
                "the hand doesn't hold the book", measured=opening(robot, books.book), cause=causes.NOT_HELD
            )
        end = yield from self._end(robot, model)
        start = robot.arm_model.forward(robot.arm.command())
        edge = hand_to_spine(robot) + books.book.depth_mm / 1e3
        self._course = _Course(start, end, edge, held_box(robot, books.book))

    def _try(self, robot: Robot, way: str, number: int) -> Generator[None, None, bool]:
        """Return whether the book goes in; pull it out again if it jams."""
        start, end, edge, held = self._course
        yield from move_straight(robot, start @ _about(edge, *PUSH_OFFSETS[way]), held)
        pushed = yield from self._push(robot, end)
        self.found(force_n=round(self._strongest, 1), tries=number)
        if not pushed.met:
            return True
        self._resists = pushed.force
        yield from relax(robot)
        yield from move_straight(robot, start, held)
        return False

    def _say_that_it_jams(self) -> Periods:
        raise Discrepancy(
            f"the book jams: it resists with {self._resists:.0f} N",
            measured=Measured("Arm", "force that resists the push", self._resists, JAM_FORCE_N, "N"),
            cause=book_causes.JAMMED,
        )
        yield

    def _end(self, robot: Robot, model: ModelView) -> Generator[None, None, Transform]:
        """Return base_T_hand (4, 4) where the push ends; with `taught`, go to the posture before it."""
        if self.method == "planned":
            base_T_shelf = yield from measure_shelf(robot, model.places[self.shelf])
            return _before_spines(robot, base_T_shelf, robot.arm_model.forward(robot.arm.command()))
        *way, last = taught_postures(robot, "insert", 1)
        for posture in way:
            yield from move_to_joints(robot, posture)
        return robot.arm_model.forward(last)

    def _push(self, robot: Robot, end: Transform) -> Generator[None, None, Pushed]:
        """Push straight ahead half the way, which brings the book into the slot; then on to `end`."""
        start = robot.arm_model.forward(robot.arm.command())
        ahead = (end[:3, 3] - start[:3, 3]) @ end[:3, 0] / 2
        halfway = start.copy()
        halfway[:3, 3] += ahead * end[:3, 0]
        pushed = yield from push(robot, halfway, INSERT_SPEED_M_S, JAM_FORCE_N)
        if not pushed.met:
            aside = yield from _yield_aside(robot)
            self._base_T_end = end @ transform((0.0, aside, 0.0))
            self.found(yielded_mm=round(1e3 * aside, 1))
            pushed = yield from push(robot, self._base_T_end, INSERT_SPEED_M_S, JAM_FORCE_N)
        self._strongest = max(self._strongest, pushed.force)
        return pushed

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the book slips out of the hand."""
        if self._base_T_end is not None:
            watch_grip(robot, model.of(Books).book)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the book is still held after the push.

        Raises:
            Discrepancy: the hand is not where the push should have ended.
        """
        books = model.of(Books)
        if self._base_T_end is None or books.book is None:
            return False
        off = float(np.linalg.norm(robot.base_T("hand")[:3, 3] - self._base_T_end[:3, 3]))
        self.found(off_mm=round(1e3 * off, 1))
        if exceeds(off, PUSH_END_TOLERANCE_M):
            left = Measured("Arm", "left to where the push ends", 1e3 * off, 1e3 * PUSH_END_TOLERANCE_M, "mm")
            raise Discrepancy(
                "the hand doesn't reach where the push ends", measured=left, cause=causes.OFF_GOAL
            )
        return holds(robot, books.book)
        yield

    def meant_contacts(self, model: WorldModel) -> Several[MeantContact]:
        """Return the intended contacts of the held book with its shelf and the two neighbours of its slot."""
        return row_contacts(model, self.shelf)

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Pull the book straight back out of its slot.

        Raises:
            NeedsPerson: the strongest force of the pushes may have pushed a neighbour back.
        """
        yield from retrace(robot, start, trace)
        if self._strongest > PUSHES_BACK:
            raise NeedsPerson(
                f"{self._strongest:.0f} N may have pushed a neighbour back",
                Measured("Arm", "strongest force of the push", self._strongest, PUSHES_BACK, "N"),
                cause=book_causes.NEIGHBOUR_PUSHED,
            )


def _before_spines(robot: Robot, base_T_shelf: Transform, base_T_hand: Transform) -> Transform:
    """Return the pose of the hand (4, 4) further along the shelf's x, its tips just before the spines."""
    shelf_T_hand = inverse(base_T_shelf) @ base_T_hand
    away = TIPS_BEFORE + hand_to_tips(robot)
    if shelf_T_hand[0, 3] > -away:
        ahead = Measured(
            "RangeSensor",
            "the hand before the shelf's front",
            -1e3 * float(shelf_T_hand[0, 3]),
            1e3 * away,
            "mm",
        )
        raise Discrepancy(
            "the hand is too close to the shelf to push a book in", measured=ahead, cause=causes.OFF_GOAL
        )
    shelf_T_hand[0, 3] = -away
    return base_T_shelf @ shelf_T_hand


def _yield_aside(robot: Robot) -> Generator[None, None, float]:
    """Let the hand yield to the slot's sides until they hardly press; return its way to the left, in [m]."""
    start = robot.arm_model.forward(robot.arm.command())
    aside = 0.0
    while abs(aside) < MOST_ASIDE and abs(force := float((yield from awaited_force(robot))[1])) > SIDE_FORCE:
        aside += math.copysign(ASIDE, force)
        yield from push(robot, start @ transform((0.0, aside, 0.0)), INSERT_SPEED_M_S, np.inf)
    return aside


def _about(edge: float, aside: float, turn: float) -> Transform:
    """Return start_T_hand (4, 4) of a hand moved left by `aside` in [m], and turned left by `turn` in [rad]
    around a point `edge` ahead of it in [m].
    """
    there = transform((edge, aside, 0.0), (0.0, 0.0, turn))
    return there @ transform((-edge, 0.0, 0.0))
