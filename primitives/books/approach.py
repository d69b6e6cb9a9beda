"""APPROACH: bring the held book before its slot."""

from __future__ import annotations

from collections.abc import Generator
from typing import ClassVar

from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.book_boxes import held_box, shelf_boxes
from handcart.primitives.books.book_grip import (
    GRIP_HEIGHT,
    book_in,
    hand_to_spine,
    holds,
    opening,
    unlike_book,
)
from handcart.primitives.books.books import Books, Slot
from handcart.primitives.books.catalogue import Book
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import CARRIES_OBJECT
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.books.slots import Gap
from handcart.robotics.perception.drawing.overlay import draw_overlay

from .hand_view import look
from .shelf_front import measure_shelf
from .slot_edge import moved, seen_past, side_near, slot_edge

SHELF_CLEARANCE_M = 0.035  # from the book's fore-edge to the shelf's front
BOARD_CLEARANCE_M = 0.006  # from the book's foot to the board
CENTRING_MAX_VIEWS = 4
CENTRING_TOLERANCE_M = 0.0005  # off its slot's middle that the hand needn't move for
SIDE_SEARCH_RADIUS_M = 0.010  # from where SEARCH saw it that the slot's side is looked for
SIDE_UNAIDED_RADIUS_M = 0.005  # likewise where only its position distinguishes it from another edge


class Approach(ActionPrimitive):
    """Bring the held book before its slot, straight and centred, just above the board.

    A planned motion leads to the slot that SEARCH found. There the camera, left of the hand, sees the slot's
    left side past the book. The hand is moved until the book's middle is half a slot's width from that side.
    Hand and slot are measured in one picture, so that errors of base, arm and SEARCH cancel.
    """

    shelf: PlaceName
    """The place before the shelf."""
    correct: bool = True
    """Correct the hand by the camera's picture."""

    needs: ClassVar = (Arm, Gripper, Camera, RangeSensor)
    reads: ClassVar = ("places", "book")
    writes: ClassVar = ("slot",)
    hand: ClassVar = CARRIES_OBJECT

    _held: Box | None = PrivateAttr(default=None)
    _around: tuple[Box, ...] = PrivateAttr(default=())

    @override
    def thing(self, model: ModelView) -> str:
        return book_in(model)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return why the book cannot be brought to its slot (another book is held, or the slot is unknown);
        "" if it can.
        """
        slot = model.of(Books).slot
        known = slot is not None and slot.shelf == self.shelf
        return unlike_book(robot, model) or ("" if known else f"no slot is known on {self.shelf}")

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        book, slot = books.book, books.slot
        if book is None or not holds(robot, book):
            raise Discrepancy(
                "the hand doesn't hold the book", measured=opening(robot, book), cause=causes.NOT_HELD
            )
        if slot is None or slot.shelf != self.shelf:
            raise Discrepancy(f"no slot is known on {self.shelf}", permanent=True, cause=causes.NOT_KNOWN)
        place = model.places[self.shelf]
        base_T_shelf = yield from measure_shelf(robot, place)
        assert place.shelf is not None  # it was measured
        self._held, self._around = held_box(robot, book), shelf_boxes(base_T_shelf, place.shelf)
        goal = _before(robot, book, (slot.left + slot.right) / 2)
        yield from move_to_pose(robot, base_T_shelf @ goal, self._held, self._around)
        if self.correct:
            books.slot = yield from self._centre(robot, base_T_shelf, goal, slot)

    def _centre(
        self, robot: Robot, base_T_shelf: Transform, goal: Transform, slot: Slot
    ) -> Generator[None, None, Slot]:
        """Look and move until the hand is before the slot's middle; return the slot as seen from there.

        Args:
            robot: its hand holds the book before the shelf.
            base_T_shelf: (4, 4), as measured.
            goal: (4, 4) shelf_T_hand before the slot as known so far.
            slot: the slot as known so far, in the shelf's frame.
        """
        for number in range(1, CENTRING_MAX_VIEWS + 1):
            slot = yield from self._measured(robot, base_T_shelf, slot)
            hand = inverse(base_T_shelf) @ robot.base_T("hand")
            off = float((slot.left + slot.right) / 2 - hand[1, 3])
            self.found(looks=number, off_mm=round(1e3 * off, 2))
            if number == 1:
                self.found(corrected_mm=round(1e3 * off, 2))
            if abs(off) <= CENTRING_TOLERANCE_M:
                return slot
            goal[1, 3] += off
            yield from move_straight(robot, base_T_shelf @ goal, self._held, self._around)
        left = Measured(
            "Camera", "the hand off its slot's middle", 1e3 * abs(off), 1e3 * CENTRING_TOLERANCE_M, "mm"
        )
        raise Discrepancy(
            f"the hand doesn't come before the slot: {1e3 * off:.1f} mm are left",
            measured=left,
            cause=causes.OFF_GOAL,
        )

    def _measured(self, robot: Robot, base_T_shelf: Transform, slot: Slot) -> Generator[None, None, Slot]:
        """Return the slot, shifted to where a picture shows its left side now."""
        view = yield from look(robot, base_T_shelf, self._held)
        strips = seen_past(view)
        shift = moved(strips, slot.sides, SIDE_SEARCH_RADIUS_M)
        if shift is None:
            left = slot_edge(strips, slot.left, SIDE_SEARCH_RADIUS_M, SIDE_UNAIDED_RADIUS_M)
        else:
            left = side_near(strips, slot.left + shift)
        now = slot if left is None else slot.moved(left - slot.left)
        self.evidence.pictures["slot"] = draw_overlay(
            view.image,
            gaps=[Gap(now.left, now.right)],
            camera=view.camera,
            camera_T_shelf=view.camera_T_shelf,
        )
        if left is None:
            unseen = Measured(
                "Camera", "an edge near where the slot's side was", None, 1e3 * SIDE_SEARCH_RADIUS_M, "mm"
            )
            raise Discrepancy(
                f"the slot's side is not seen where SEARCH saw it: {_beside(slot)}",
                measured=unseen,
                cause=causes.NOT_SEEN,
            )
        return now


def _before(robot: Robot, book: Book, lateral: float) -> Transform:
    """Return shelf_T_hand (4, 4) with the book straight before the shelf at y `lateral` in [m]."""
    away = SHELF_CLEARANCE_M + book.depth_mm / 1e3 + hand_to_spine(robot)
    return transform((-away, lateral, BOARD_CLEARANCE_M + GRIP_HEIGHT))


def _beside(slot: Slot) -> str:
    return f"right of {slot.after}" if slot.after else "at the left end of the row"
