"""PICK_UP: take the book from the tray."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import ClassVar, Literal

from pydantic import PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.book_boxes import held_box
from handcart.primitives.books.book_grip import GRIP_HEIGHT, close_on, hand_to_spine, holds, opening
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import Book, name_of_book
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.discrepancy import Discrepancy, Measured
from handcart.primitives.contract.meant_contact import MeantContact
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.primitives.motions.arm_motion import (
    move_straight,
    move_to_joints,
    move_to_pose,
    move_to_posture,
)
from handcart.primitives.motions.grip import open_to
from handcart.primitives.motions.pushing import push
from handcart.primitives.motions.taught import taught_postures
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.landmarks.tag_reader import read_tags, tag_pose

BEFORE = 0.05  # [m] before the grip from which the hand goes in straight
LIFT = 0.12  # [m]: clear of the tray's rim and of what lies on it
SPEED = 0.05  # [m/s] of the hand near the book
TOUCH = 6.0  # [N]: more means that a finger runs into the book instead of beside it
LOOKS = 3  # pictures in which the tag is looked for
TAG_SIDE = 0.010  # [m] of the tag's black square


class PickUp(ActionPrimitive):
    """Take the book from the tray: grip the rear of its covers, beside the spine, lift it and carry it.

    Planned, the hand comes in line with the book where RECOGNIZE saw it; taught, it plays back postures
    (`pick_up_1` before the book, `pick_up_2` gripping it, `pick_up_3` and on lifted) and trusts that the book
    stands where it stood when they were taught.
    """

    method: Literal["planned", "taught"] = "planned"
    """How the hand finds its way."""

    needs: ClassVar = (Arm, Gripper, Camera)
    reads: ClassVar = ("book", "book_pose", "catalogue")

    _stands: bool = PrivateAttr(default=False)
    _held: bool = PrivateAttr(default=False)

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Where the book's tag is, in the base frame; nothing where it isn't seen."""
        books = model.of(Books)
        if books.book is None:
            raise Discrepancy("no book has been recognized", permanent=True)
        yield from move_to_posture(robot, "look_at_tag", around=_standing(robot, model))
        yield from settle(robot)
        for _ in range(LOOKS):
            yield
            for tag in read_tags(robot.picture(), family=books.catalogue.tags):
                if tag.id == books.book.accession:
                    camera_T_tag = tag_pose(tag, robot.camera.model, TAG_SIDE)
                    place = robot.base_T("hand") @ robot.camera.hand_T_camera @ camera_T_tag[:, 3]
                    self._stands = True
                    return {"book": (float(place[0]), float(place[1]), float(place[2]))}
        return {}

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        book, pose = books.book, books.book_pose
        if book is None or pose is None or not self._stands:
            unseen = Measured("Camera", "pictures in which the book's tag was read", 0, 1)
            raise Discrepancy("the book isn't seen on the tray", measured=unseen)
        yield from open_to(robot, None)
        if self.method == "taught":
            yield from self._taught(robot, book)
        else:
            base_T_grip = pose.lift(_tray(robot)) @ transform((-hand_to_spine(robot), 0.0, GRIP_HEIGHT))
            before = base_T_grip @ transform((-BEFORE, 0.0, 0.0))
            yield from move_to_pose(robot, before, around=_standing(robot, model))
            yield from self._planned(robot, book, base_T_grip)
        self.found(width_mm=round(1e3 * robot.gripper.width(), 1))

    def _planned(self, robot: Robot, book: Book, base_T_grip: Transform) -> Periods:
        pushed = yield from push(robot, base_T_grip, SPEED, TOUCH)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, TOUCH, "N")
            raise Discrepancy("a finger runs into the book: it stands crooked on the tray", measured=felt)
        yield from self._close(robot, book)
        lifted = base_T_grip.copy()
        lifted[2, 3] += LIFT
        yield from move_straight(robot, lifted, held_box(robot, book))
        yield from move_to_posture(robot, "carry", held=held_box(robot, book))

    def _taught(self, robot: Robot, book: Book) -> Periods:
        before, grip, *lifted = taught_postures(robot, "pick_up", 3)
        yield from move_to_joints(robot, before)
        yield from move_to_joints(robot, grip)
        yield from self._close(robot, book)
        for posture in lifted:
            yield from move_to_joints(robot, posture, held=held_box(robot, book))

    def _close(self, robot: Robot, book: Book) -> Periods:
        yield from self.intend("the fingers close on the book")
        yield from close_on(robot, book)
        self._held = True

    def watch(self, robot: Robot, model: ModelView) -> None:
        """A book that slips out of the hand."""
        if self._held and not robot.gripper.closed_on_something():
            raise Discrepancy(
                "the book slipped out of the hand", measured=opening(robot, model.of(Books).book)
            )

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """The fingers press on something as thick as the book."""
        books = model.of(Books)
        return books.book is not None and holds(robot, books.book)
        yield

    def meant_contacts(self, model: WorldModel) -> Sequence[MeantContact]:
        """Its book, which stands on the tray."""
        books = model.of(Books)
        book = "" if books.book is None else name_of_book(books.book)
        return MeantContact("hand", book), MeantContact("held", "tray")

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Played backwards, the lifted book stands on the tray again before the fingers open."""
        self._held = False
        yield from retrace(robot, start, trace)


def _tray(robot: Robot) -> float:
    """Height of the tray's top in the base frame, in [m]."""
    return robot.spec.tray_shape.top


def _standing(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """The book on the tray, in the base frame, as far as it was seen."""
    books = model.of(Books)
    book, pose = books.book, books.book_pose
    if book is None or pose is None:
        return ()
    depth, thickness, height = (1e-3 * size for size in (book.depth_mm, book.thickness_mm, book.height_mm))
    middle = pose.lift(_tray(robot)) @ transform((depth / 2, 0.0, height / 2))
    return (Box(middle, (depth, thickness, height), "book on the tray"),)
