"""RECOGNIZE: identify and locate the book on the tray."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.robot.robot import Robot
from handcart.primitives.books import book_causes
from handcart.primitives.books.book_boxes import tray_box
from handcart.primitives.books.books import Books
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import move_straight, move_to_posture
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.preconditions.hand_use import NEEDS_EMPTY
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.landmarks.tag_family import TagFamily
from handcart.robotics.perception.landmarks.tag_reader import Tag, read_tags, tag_pose

TAG_POSTURE = "look_at_tag"
VIEW_OFFSETS_M = ((0.0, 0.0), (0.0, 0.025), (0.0, -0.025), (0.02, 0.0))  # of views: left and up, in [m]
MIN_SIGHTINGS = 3  # views in which the tag was read
VIEW_MAX_PICTURES = 2  # from each view, until the tag is read

TAG_SIDE = 0.010  # [m] of the tag's black square
REARMOST, FOREMOST = -0.04, 0.14  # [m] from the tray's rear: possible positions of a spine
ASIDE_ON_TRAY = 0.10  # [m] from the tray's middle, likewise
DEPTH_WEIGHT = 5e-4  # of a distance along a line of sight: 1 % of 0.2 m, against 0.05 mm across


class _Sighting(NamedTuple):
    number: int
    eye: FloatArray
    """Position (3,) of the camera in the base frame, in [m]."""
    place: FloatArray
    """Position (3,) of the tag's middle in the base frame by this picture alone, in [m]."""


class Recognize(ActionPrimitive):
    """Read the tag of the book on the tray, and look it up in the catalogue.

    The tag is read in a few pictures from neighbouring positions. The tag's position on the spine is where
    the lines of sight of these pictures intersect. The heading of the book cannot be measured by a tag of 10
    mm, so that the book is assumed to be straight; closing fingers will straighten it.
    """

    needs: ClassVar = (Arm, Camera)
    reads: ClassVar = ("catalogue",)
    writes: ClassVar = ("book", "book_pose")
    hand: ClassVar = NEEDS_EMPTY

    _seen: list[_Sighting] = PrivateAttr(default_factory=list)
    _looks: int = PrivateAttr(default=0)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        around = (tray_box(robot),)
        yield from move_to_posture(robot, TAG_POSTURE, around=around)
        start = robot.arm_model.forward(robot.arm.command())
        for aside, up in VIEW_OFFSETS_M:
            yield from move_straight(robot, start @ transform((0.0, aside, up)), around=around)
            yield from self._read(robot, model.of(Books).catalogue.tags)
            if len(self._seen) >= MIN_SIGHTINGS:
                break
        yield from move_straight(robot, start, around=around)
        self._conclude(model)

    def _read(self, robot: Robot, family: TagFamily) -> Generator[None, None, None]:
        """Look for a tag from here."""
        yield from settle(robot)
        for _ in range(VIEW_MAX_PICTURES):
            yield
            photo = robot.photo()
            self._looks += 1
            tags = read_tags(photo.pixels, family=family)
            found = [(tag, _sighting(tag, photo.camera, photo.base_T_camera)) for tag in tags]
            found = [(tag, sighting) for tag, sighting in found if _on_tray(robot, sighting.place)]
            self._show(photo.pixels, [tag for tag, _ in found])
            if found:
                self._seen += [sighting for _, sighting in found]
                return

    def _show(self, image: ByteArray, tags: list[Tag]) -> None:
        if tags or not self._seen:
            self.evidence.pictures["tray"] = draw_overlay(image, tags)

    def _conclude(self, model: ModelView) -> None:
        books = model.of(Books)
        if not self._seen:
            unread = Measured("Camera", f"of {self._looks} pictures those in which a tag was read", 0, 1)
            raise Discrepancy("no tag can be read on the tray", measured=unread, cause=causes.NOT_SEEN)
        numbers = sorted({sighting.number for sighting in self._seen})
        if len(numbers) > 1:
            raise Discrepancy(
                f"there are several tags on the tray: {', '.join(map(str, numbers))}",
                measured=Measured("Camera", "different tags read", len(numbers), 1),
                cause=causes.AMBIGUOUS,
            )
        book = books.catalogue.by_accession.get(numbers[0])
        if book is None:
            read = Measured("Camera", "number of the tag that was read", numbers[0])
            unknown = f"the book with the tag {numbers[0]} is not in the catalogue"
            raise Discrepancy(unknown, permanent=True, measured=read, cause=book_causes.UNKNOWN_BOOK)
        x, y, _ = _place(self._seen)
        books.book = book
        books.book_pose = Pose2(float(x), float(y), 0.0)
        self.found(
            accession=float(book.accession),
            call=book.call,
            x_mm=round(1e3 * float(x), 1),
            y_mm=round(1e3 * float(y), 1),
            views=len(self._seen),
        )


def _sighting(tag: Tag, camera: CameraModel, base_T_camera: Transform) -> _Sighting:
    camera_T_tag = tag_pose(tag, camera, TAG_SIDE)
    return _Sighting(tag.id, base_T_camera[:3, 3], (base_T_camera @ camera_T_tag)[:3, 3])


def _place(seen: Sequence[_Sighting]) -> FloatArray:
    """Return the best intersection of the lines of sight, (3,) in [m].

    Least squares over the distances from the lines, with little weight along them: several lines give the
    depth more exactly than the size of a small tag.
    """
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for sighting in seen:
        sight = sighting.place - sighting.eye
        sight /= np.linalg.norm(sight)
        across = np.eye(3) - (1.0 - DEPTH_WEIGHT) * np.outer(sight, sight)
        normal, right = normal + across, right + across @ sighting.place
    return np.asarray(np.linalg.solve(normal, right))


def _on_tray(robot: Robot, place: FloatArray) -> bool:
    tray = robot.spec.tray_shape
    ahead, aside = place[0] - tray.rear, place[1] - tray.middle[1]
    return bool(REARMOST < ahead < FOREMOST and abs(aside) < ASIDE_ON_TRAY)
