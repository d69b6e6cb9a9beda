"""RELEASE: let the book go in its slot, and push it home."""

from __future__ import annotations

from collections.abc import Generator
from collections.abc import Sequence as Several
from typing import ClassVar

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from pydantic import PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.books import book_causes
from handcart.primitives.books.book_boxes import shelf_boxes
from handcart.primitives.books.book_grip import GRIP_HEIGHT, holds, opening
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import name_of_book
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.tree_primitive import leaves
from handcart.primitives.knowledge.meant_contact import MeantContact
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import move_straight, move_to_posture
from handcart.primitives.motions.grip import close, hand_to_tips, open_to
from handcart.primitives.motions.pushing import push, relax
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import LETS_GO
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.perception.books.call_number import parse
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.drawing.overlay import draw_overlay

from .book_row import row_contacts
from .held_book import HeldBookPrimitive
from .shelf_front import measure_shelf

LOWER_SPEED = 0.01  # [m/s]
BOARD_CONTACT_FORCE_N = 3.0  # from below: the book is on the board
TOO_LOW = 0.006  # [m] below the board's expected height: there is no board
RELEASE_CLEARANCE_M = 0.012  # that the fingers open wider than the book
BACK_OFF = 0.06  # [m]: the tips leave the book's rear
HOME_SPEED = 0.02  # [m/s]
HOME_MAX_FORCE_N = 8.0  # sliding home takes 3
PUSH_OVERTRAVEL_M = 0.008  # that the push may be commanded past flush: the arm yields to friction
PUSH_MIN_FORCE_N = 1.5  # below this the fingers pushed nothing: they passed the book by
FLUSH_DEPTH_M = 0.0  # behind the shelf's front edge, to which the tips push: spines are within 3 mm of it
MAX_OVERHANG_M = 0.006  # before the front edge: a book that stays there isn't home
WITHDRAWN_DISTANCE_M = 0.18  # from the tips to the shelf's front, after withdrawing and while looking
LOOK_HEIGHT = 0.09  # [m] of the camera above the board: labels are near a book's lower end
SAME_PLACE = 0.012  # [m] between where the book was let go and where its label is seen


class Release(HeldBookPrimitive):
    """Release the book in its slot and push it fully in: lower, open, back off, close, push, withdraw, look.

    Once the fingers have opened, the action cannot be undone, because a book that is fully in its slot cannot
    be gripped. In the end its label must be read in its slot, between the right neighbours; otherwise the
    action gives up.
    """

    shelf: PlaceName
    """The place before the shelf."""

    needs: ClassVar = (Arm, Gripper, Camera, RangeSensor)
    reads: ClassVar = ("places", "catalogue", "book", "slot")
    hand: ClassVar = LETS_GO

    _base_T_shelf: Transform | None = PrivateAttr(default=None)
    _lateral: float = PrivateAttr(default=0.0)
    """y in the shelf frame where the book is let go, in [m]."""
    _open_to: float | None = PrivateAttr(default=None)
    """Target opening of the fingers in [m], while they open."""
    _is_home: bool = PrivateAttr(default=False)
    """True once the book was pushed home."""
    _seen: bool | None = PrivateAttr(default=None)
    """Whether the label was read in its slot; None if it was not looked at."""

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        """Return the behaviour tree of releasing a book, a sequence of steps."""
        steps = {
            "measure the shelf": lambda: self._measure(robot, model),
            "lower the book onto the board": lambda: self._lower(robot),
            "open the fingers": lambda: self._open(robot, model),
            "back off": lambda: self._move_in_shelf(robot, -BACK_OFF),
            "close the fingers": lambda: close(robot),
            "push the book home": lambda: self._push_home(robot),
            "withdraw": lambda: self._withdraw(robot),
            "look at the shelf": lambda: self._look(robot),
        }
        return Sequence("release the book", memory=True, children=leaves(steps))

    def _measure(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        if books.book is None or not holds(robot, books.book):
            raise Discrepancy(
                "the hand doesn't hold the book", measured=opening(robot, books.book), cause=causes.NOT_HELD
            )
        self._base_T_shelf = yield from measure_shelf(robot, model.places[self.shelf])
        self._lateral = float(self._hand(robot)[1, 3])

    def _lower(self, robot: Robot) -> Periods:
        foot = float(self._hand(robot)[2, 3]) - GRIP_HEIGHT
        goal = robot.arm_model.forward(robot.arm.command())
        goal[2, 3] -= max(0.002, foot + TOO_LOW)
        pushed = yield from push(robot, goal, LOWER_SPEED, BOARD_CONTACT_FORCE_N)
        if not pushed.met:
            felt = Measured("Arm", "force from below", pushed.force, BOARD_CONTACT_FORCE_N, "N")
            raise Discrepancy("no board is below the book", measured=felt, cause=causes.NO_SUPPORT)
        self.found(lowered_mm=round(1e3 * (foot + GRIP_HEIGHT - float(self._hand(robot)[2, 3])), 1))
        yield from relax(robot)

    def _open(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        yield from self.intend("the fingers let the book go")
        self._open_to = RELEASE_CLEARANCE_M + (books.book.thickness_mm / 1e3 if books.book else 0.0)
        self.point_of_no_return("the fingers let the book go")
        yield from open_to(robot, self._open_to)
        self._open_to = None

    def _push_home(self, robot: Robot) -> Periods:
        tips = float(self._hand(robot)[0, 3]) + hand_to_tips(robot)
        goal = self._in_shelf(robot, FLUSH_DEPTH_M + PUSH_OVERTRAVEL_M - tips)
        pushed = yield from push(
            robot, goal, HOME_SPEED, HOME_MAX_FORCE_N, lambda: self._tips(robot) >= FLUSH_DEPTH_M
        )
        proud = -self._tips(robot)
        self.found(proud_mm=round(1e3 * proud, 1), push_n=round(pushed.force, 1))
        if proud > MAX_OVERHANG_M:
            raise Discrepancy(
                f"the book can't be pushed home: it protrudes {1e3 * proud:.0f} mm",
                measured=Measured(
                    "Arm", "the finger tips before flush", 1e3 * proud, 1e3 * MAX_OVERHANG_M, "mm"
                ),
                cause=book_causes.PROTRUDES,
            )
        if pushed.force < PUSH_MIN_FORCE_N:
            felt = Measured("Arm", "force of the push", pushed.force, PUSH_MIN_FORCE_N, "N")
            raise Discrepancy(
                "the fingers don't meet the book: it may protrude", measured=felt, cause=book_causes.PROTRUDES
            )
        self._is_home = True

    def _withdraw(self, robot: Robot) -> Periods:
        yield from self._move_in_shelf(robot, -WITHDRAWN_DISTANCE_M - self._tips(robot))

    def _look(self, robot: Robot) -> Periods:
        """Bring the camera before the slot, at the present distance of the hand."""
        shelf_T_hand = self._hand(robot)
        eye = robot.camera.hand_T_camera[:3, 3]
        goal = np.eye(4)
        goal[:3, 3] = (shelf_T_hand[0, 3], self._lateral - eye[1], LOOK_HEIGHT - eye[2])
        yield from move_straight(robot, self._shelf @ goal)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Read the labels in a picture, put the arm away, and return whether the book is where it belongs.

        Its label must be read in its slot, between those neighbours that the order of call numbers demands.
        """
        if model.of(Books).book is None:
            return False
        yield
        photo = robot.photo()
        camera_T_shelf = inverse(photo.base_T_camera) @ self._shelf
        known = [
            number for book in model.of(Books).catalogue.books if (number := parse(book.call)) is not None
        ]
        reader = OcrLabelReader(known or None)
        labels = yield from robot.compute(reader.read, photo.pixels, photo.camera, camera_T_shelf)
        self.evidence.pictures["after_release"] = draw_overlay(photo.pixels, labels=labels)
        self._seen = self._stands(labels, model)
        yield from self._put_away(robot, model)
        return self._seen

    def meant_contacts(self, model: WorldModel) -> Several[MeantContact]:
        """Return the intended contacts of the fingers and of the book.

        The fingers touch the book; the book touches its shelf and the two neighbours of its slot.
        """
        books = model.of(Books)
        own = "" if books.book is None else name_of_book(books.book)
        return MeantContact("hand", own), *row_contacts(model, self.shelf)

    def finish(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Finish an action that was interrupted after the fingers began to open.

        The hand is pulled back and the arm moved to its posture `home`. If a fault of the robot interrupted
        the action, the book is first pushed fully into its slot.

        Returns:
            True if the book was pushed fully into its slot and its label was read there.
        """
        yield from settle(robot)
        if self._open_to is not None:
            yield from open_to(robot, self._open_to)
            self._open_to = None
        if self.met_fault and not self._is_home:
            try:
                yield from self._move_in_shelf(robot, -BACK_OFF)
                yield from close(robot)
                yield from self._push_home(robot)
            except Discrepancy as found:
                self.found(pushed=found.reason)
        if self._tips(robot) > -WITHDRAWN_DISTANCE_M:
            yield from self._withdraw(robot)
        if not (self.met_fault and self._is_home):
            yield from self._put_away(robot, model)
            return False
        if self._seen is None:
            yield from self._look(robot)
            return (yield from self.effect(robot, model))
        yield from self._put_away(robot, model)
        return self._seen

    def _put_away(self, robot: Robot, model: ModelView) -> Periods:
        shelf = model.places[self.shelf].shelf
        around = () if shelf is None else shelf_boxes(self._shelf, shelf)
        yield from move_to_posture(robot, "home", around=around)

    def _stands(self, labels: list[Label], model: ModelView) -> bool:
        """Return whether the book's label was read where the hand released it, and in order."""
        books = model.of(Books)
        numbers = [(label.lateral, label.call_number) for label in labels if label.call_number is not None]
        own = parse(books.book.call) if books.book else None
        near = [y for y, number in numbers if number == own and abs(y - self._lateral) < SAME_PLACE]
        if own is None or not near:
            return False
        self.found(label_off_mm=round(1e3 * (near[0] - self._lateral), 1))
        if books.slot is None:
            return True
        left = [number for y, number in numbers if y > near[0]]
        right = [number for y, number in numbers if y < near[0]]
        return parse(books.slot.after) not in right and parse(books.slot.before) not in left

    def _move_in_shelf(self, robot: Robot, ahead: float) -> Periods:
        """Move the hand along the shelf's x by `ahead` [m]."""
        yield from relax(robot)
        yield from move_straight(robot, self._in_shelf(robot, ahead))

    def _in_shelf(self, robot: Robot, ahead: float) -> Transform:
        base_T_hand = robot.arm_model.forward(robot.arm.command())
        base_T_hand[:3, 3] += ahead * self._shelf[:3, 0]
        return base_T_hand

    def _tips(self, robot: Robot) -> float:
        """x of the finger tips in the shelf frame, by the measured joints, in [m]."""
        return float((self._hand(robot) @ np.array([hand_to_tips(robot), 0.0, 0.0, 1.0]))[0])

    def _hand(self, robot: Robot) -> Transform:
        """shelf_T_hand (4, 4) by the measured joints."""
        return inverse(self._shelf) @ robot.base_T("hand")

    @property
    def _shelf(self) -> Transform:
        if self._base_T_shelf is None:
            raise Discrepancy("the shelf hasn't been measured", cause=causes.NOT_KNOWN)
        return self._base_T_shelf
