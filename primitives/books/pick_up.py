"""PICK_UP: take the book from the tray."""

from __future__ import annotations

from collections.abc import Generator
from collections.abc import Sequence as Several
from typing import ClassVar, Literal

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.books.book_boxes import held_box
from handcart.primitives.books.book_grip import (
    GRIP_HEIGHT,
    book_in,
    close_on,
    hand_to_spine,
    holds,
    watch_grip,
)
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import Book, name_of_book
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.contract.tree_primitive import Step, TreePrimitive, leaves
from handcart.primitives.knowledge.meant_contact import MeantContact
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
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import TAKES_OBJECT
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Seen, Snapshot, settle
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.landmarks.tag_reader import read_tags, tag_pose

GRIP_APPROACH_M = 0.05  # before the grip from which the hand goes in straight
LIFT_HEIGHT_M = 0.12  # clear of the tray's rim and of what lies on it
GRIP_SPEED_M_S = 0.05  # of the hand near the book
GRIP_TOUCH_FORCE_N = 6.0  # more means that a finger runs into the book instead of beside it
TAG_MAX_PICTURES = 3  # pictures in which the tag is looked for
TAG_SIDE = 0.010  # [m] of the tag's black square


class PickUp(TreePrimitive):
    """Take the book from the tray: grip the rear of its covers, next to the spine, lift it and carry it.

    With the method `planned`, the hand moves to the book's pose that RECOGNIZE measured. With `taught`, the
    hand plays back taught postures: `pick_up_1` before the book, `pick_up_2` gripping it, `pick_up_3` and
    later ones with the book lifted. The book must then be where it was when the postures were taught.
    """

    method: Literal["planned", "taught"] = "planned"
    """Source of the hand's motion."""

    needs: ClassVar = (Arm, Gripper, Camera)
    reads: ClassVar = ("book", "book_pose", "catalogue")
    hand: ClassVar = TAKES_OBJECT

    _book: Book = PrivateAttr()
    _base_T_grip: Transform = PrivateAttr()
    """Planned pose (4, 4) of the hand that grips the book."""
    _stands: bool = PrivateAttr(default=False)
    _held: bool = PrivateAttr(default=False)

    @override
    def thing(self, model: ModelView) -> str:
        return book_in(model)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return a reason if the book or its pose is unknown; empty otherwise."""
        books = model.of(Books)
        if books.book is None or books.book_pose is None:
            return "no book has been recognized on the tray"
        return ""

    def observe(self, robot: Robot, model: ModelView) -> Generator[None, None, Seen]:
        """Return the position of the book's tag in the base frame, in [m], under the name `book`.

        The result is empty if the tag is not seen.
        """
        books = model.of(Books)
        if books.book is None:
            raise Discrepancy("no book has been recognized", permanent=True, cause=causes.NOT_KNOWN)
        yield from move_to_posture(robot, "look_at_tag", around=_standing(robot, model))
        yield from settle(robot)
        for _ in range(TAG_MAX_PICTURES):
            yield
            photo = robot.photo()
            for tag in read_tags(photo.pixels, family=books.catalogue.tags):
                if tag.id == books.book.accession:
                    camera_T_tag = tag_pose(tag, photo.camera, TAG_SIDE)
                    place = photo.base_T_camera @ camera_T_tag[:, 3]
                    self._stands = True
                    return {"book": (float(place[0]), float(place[1]), float(place[2]))}
        return {}

    def tree(self, robot: Robot, model: ModelView) -> Behaviour:
        """Return the behaviour tree of picking up a book, a sequence of steps; `method` decides the hand's
        motion.
        """
        ways = {"planned": (self._go, self._carry), "taught": (self._go_as_taught, self._carry_as_taught)}
        there, away = ways[self.method]
        steps: dict[str, Step] = {
            "make sure that it is seen, and open the fingers": lambda: self._open(robot, model),
            "go to the grip": lambda: there(robot, model),
            "close the fingers on it": lambda: self._close(robot),
            "lift and carry it": lambda: away(robot),
            "measure how wide it is": lambda: self._measure(robot),
        }
        return Sequence("pick the book up", memory=True, children=leaves(steps))

    def _open(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        if books.book is None or books.book_pose is None or not self._stands:
            unseen = Measured("Camera", "pictures in which the book's tag was read", 0, 1)
            raise Discrepancy("the book isn't seen on the tray", measured=unseen, cause=causes.NOT_SEEN)
        self._book, at_grip = books.book, transform((-hand_to_spine(robot), 0.0, GRIP_HEIGHT))
        self._base_T_grip = books.book_pose.lift(_tray(robot)) @ at_grip
        yield from open_to(robot, None)

    def _go(self, robot: Robot, model: ModelView) -> Periods:
        """Line up with the book, then move straight."""
        before = self._base_T_grip @ transform((-GRIP_APPROACH_M, 0.0, 0.0))
        yield from move_to_pose(robot, before, around=_standing(robot, model))
        pushed = yield from push(robot, self._base_T_grip, GRIP_SPEED_M_S, GRIP_TOUCH_FORCE_N)
        if pushed.met:
            felt = Measured("Arm", "force that resists the hand", pushed.force, GRIP_TOUCH_FORCE_N, "N")
            raise Discrepancy(
                "a finger runs into the book: it is askew on the tray",
                measured=felt,
                cause=causes.ARM_BLOCKED,
            )

    def _go_as_taught(self, robot: Robot, model: ModelView) -> Periods:
        before, grip, *_ = taught_postures(robot, "pick_up", 3)
        yield from move_to_joints(robot, before)
        yield from move_to_joints(robot, grip)

    def _close(self, robot: Robot) -> Periods:
        yield from self.intend("the fingers close on the book")
        yield from close_on(robot, self._book)
        self._held = True

    def _carry(self, robot: Robot) -> Periods:
        lifted, held = self._base_T_grip.copy(), held_box(robot, self._book)
        lifted[2, 3] += LIFT_HEIGHT_M
        yield from move_straight(robot, lifted, held)
        yield from move_to_posture(robot, "carry", held=held)

    def _carry_as_taught(self, robot: Robot) -> Periods:
        _, _, *lifted = taught_postures(robot, "pick_up", 3)
        for posture in lifted:
            yield from move_to_joints(robot, posture, held=held_box(robot, self._book))

    def _measure(self, robot: Robot) -> Periods:
        self.found(width_mm=round(1e3 * robot.gripper.width(), 1))
        return
        yield

    def watch(self, robot: Robot, model: ModelView) -> None:
        """Raise a Discrepancy if the fingers no longer press on the book that they hold."""
        if self._held:
            watch_grip(robot, model.of(Books).book)

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the fingers press on an object of the book's thickness."""
        books = model.of(Books)
        return books.book is not None and holds(robot, books.book)
        yield

    def meant_contacts(self, model: WorldModel) -> Several[MeantContact]:
        """Return the intended contacts of the hand with the book, and of the book with the tray."""
        books = model.of(Books)
        book = "" if books.book is None else name_of_book(books.book)
        return MeantContact("hand", book), MeantContact("held", "tray")

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        """Play the motion backwards, so that a lifted book is put on the tray before the fingers open."""
        self._held = False
        yield from retrace(robot, start, trace)


def _tray(robot: Robot) -> float:
    """Return the height of the tray's top in the base frame, in [m]."""
    return robot.spec.tray_shape.top


def _standing(robot: Robot, model: ModelView) -> tuple[Box, ...]:
    """Return the book on the tray, in the base frame, as far as it was seen."""
    books = model.of(Books)
    book, pose = books.book, books.book_pose
    if book is None or pose is None:
        return ()
    depth, thickness, height = (1e-3 * size for size in (book.depth_mm, book.thickness_mm, book.height_mm))
    middle = pose.lift(_tray(robot)) @ transform((depth / 2, 0.0, height / 2))
    return (Box(middle, (depth, thickness, height), "book on the tray"),)
