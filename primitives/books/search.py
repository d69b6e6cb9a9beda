"""SEARCH: find where on the shelf the book belongs."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.books import book_causes
from handcart.primitives.books.book_boxes import shelf_boxes, tray_box
from handcart.primitives.books.book_grip import hand_to_spine, unlike_book
from handcart.primitives.books.books import Books, Slot
from handcart.primitives.books.catalogue import Book, Catalogue
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.place import Shelf
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import move_straight, move_to_pose
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.snapshot import is_holding
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.books.call_number import CallNumber, parse
from handcart.robotics.perception.books.gap_finder import GapFound, NoGap, find_gap, ordered
from handcart.robotics.perception.books.label_reader import Label, LabelReader
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.books.shelf_views import ShelfReading, fuse_views
from handcart.robotics.perception.books.slots import Gap, find_slots
from handcart.robotics.perception.books.spines import MIN_LEAN_RAD, SpineView, find_spines, scale_of
from handcart.robotics.perception.books.template_label_reader import TemplateLabelReader
from handcart.robotics.perception.drawing.overlay import draw_overlay

from .hand_view import HandView, held_book, look
from .label_templates import PX_PER_M, label_templates
from .shelf_front import measure_shelf
from .slot_edge import book_end

CAMERA_DISTANCE_M = 0.285  # from the camera to the spines
HELD_BOOK_CLEARANCE_M = 0.03  # that a held book keeps from them
CAMERA_HEIGHT_M = 0.082  # of the camera above the board: labels and the foot of the spines are in view
VIEW_SPACING_M = 0.125  # between views: with a thick book in the hand, a view shows 0.18 m
PANEL_MARGIN_M = 0.012  # of the side panels that is in view
CLOSE_LOOK_OFFSET_M = 0.03  # to both sides of the slot, for a closer look
SLOT_PLAY_M = 0.006  # that a slot is wider than its book, about
SLOT_SIDE_SIGMA_M = 0.001  # of a slot's sides
GAP_TOLERANCE_M = 0.004  # that an interval may be wider than it looks before it is looked at from nearby
LEFT_OF = 0.25  # [m] from a slot in which sides of books are recorded: APPROACH sees them past the held book
MAX_SIDE_GAP_M = 0.002  # between the sides of two books, at most


class Search(ActionPrimitive):
    """Look along the shelf, read the labels, and find the slot where the book belongs.

    The camera moves on a straight line from left to right and stops for each view; it looks past a book in
    the hand. A book that lies on the tray has to be picked up first, because it would be in the hand's way.
    The slot is then viewed twice more from nearly straight ahead. The slot's position is relative to the
    shelf's pose, which is measured at the start of the search and again by the primitive APPROACH.
    """

    shelf: PlaceName
    """The place before the shelf."""
    reader: Literal["ocr", "template"] = "ocr"
    """Method for reading labels: letter by letter, or by comparison with pictures of the catalogue's
    labels.
    """
    fuse: bool = True
    """Align, average and vote on several views of one book."""
    misplacement: bool = True
    """Ignore a book that is out of order."""

    needs: ClassVar = (Arm, Camera, RangeSensor)
    reads: ClassVar = ("places", "catalogue", "book", "book_pose")
    writes: ClassVar = ("slot",)

    _base_T_shelf: Transform = PrivateAttr(default_factory=lambda: np.eye(4))
    _held: Box | None = PrivateAttr(default=None)
    _around: tuple[Box, ...] = PrivateAttr(default=())
    _views: list[SpineView] = PrivateAttr(default_factory=list)
    _labels: list[Label] = PrivateAttr(default_factory=list)
    """Labels that were read in all views."""
    _thicknesses: dict[CallNumber, float] = PrivateAttr(default_factory=dict)
    """Thickness of the books in the catalogue by call number, in [m]."""
    _last: HandView | None = PrivateAttr(default=None)

    def unmet_precondition(self, robot: Robot, model: ModelView) -> str:
        """Return that the search can't begin because the hand holds another object than the recognized book;
        empty if it can.
        """
        return unlike_book(robot, model) if is_holding(robot) else ""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        books = model.of(Books)
        book, number = _wanted(model)
        place = model.places[self.shelf]
        self._base_T_shelf = yield from measure_shelf(robot, place)
        assert place.shelf is not None  # it was measured
        self._held = held_book(robot, book)
        self._around = shelf_boxes(self._base_T_shelf, place.shelf)
        if self._held is None and books.book_pose is not None:
            self._around += (tray_box(robot),)
        self._thicknesses = _thicknesses(books.catalogue)
        reader = self._make_reader([item.call for item in books.catalogue.books])
        stops = self._stops(robot, place.shelf)
        yield from self._look_from(robot, reader, stops)
        found = self._where(book, number)
        end = _end_of_row(self._reading(), number, isinstance(found, NoGap))
        if end is not None:
            yield from self._look_from(robot, reader, [end - book.thickness_mm / 1e3 - SLOT_PLAY_M])
            self._conclude(model, self._find(book, number, self._slot_at(end, book)))
            return
        if isinstance(found, NoGap):
            yield from self._look_from(robot, reader, [(a + b) / 2 for a, b in pairwise(stops)][::-1])
            found = self._where(book, number)
        if isinstance(found, GapFound):
            yield from self._look_from(
                robot, reader, [found.centre + CLOSE_LOOK_OFFSET_M, found.centre - CLOSE_LOOK_OFFSET_M]
            )
            found = self._slot_in(found, book, number)
        self._conclude(model, found)

    def _make_reader(self, calls: Sequence[str]) -> LabelReader:
        numbers: list[CallNumber] = [number for call in calls if (number := parse(call)) is not None]
        if self.reader == "template":
            return TemplateLabelReader(label_templates(numbers), PX_PER_M)
        return OcrLabelReader(numbers)

    def _stops(self, robot: Robot, shelf: Shelf) -> list[float]:
        """Return y of the camera for views that together show the complete shelf, left to right, in [m]."""
        camera = robot.camera.model
        left = right = self._away(robot) * camera.width / (2 * camera.K[0, 0])
        if self._held is not None:
            right = min(right, self._past(robot))
        first, last = (
            0.5 * shelf.width_m + PANEL_MARGIN_M - left,
            -0.5 * shelf.width_m - PANEL_MARGIN_M + right,
        )
        count = 1 + max(0, math.ceil((first - last) / VIEW_SPACING_M))
        return [float(y) for y in np.linspace(first, last, count)]

    def _away(self, robot: Robot) -> float:
        """Return the distance from the camera to the spines, in [m]."""
        if self._held is None:
            return CAMERA_DISTANCE_M
        return max(
            CAMERA_DISTANCE_M,
            hand_to_spine(robot)
            + self._held.size[0]
            + HELD_BOOK_CLEARANCE_M
            - float(robot.camera.hand_T_camera[0, 3]),
        )

    def _past(self, robot: Robot) -> float:
        """Return how far right of the camera the spines are visible past the held book, in [m]."""
        assert self._held is not None
        eye = robot.camera.hand_T_camera[:3, 3]
        ahead = hand_to_spine(robot) + self._held.size[0] - float(eye[0])
        return (float(eye[1]) - 0.5 * self._held.size[1]) * self._away(robot) / ahead - 0.003

    def _look_from(self, robot: Robot, reader: LabelReader, stops: Sequence[float]) -> Periods:
        eye = robot.camera.hand_T_camera[:3, 3]
        for y in stops:
            place = (-self._away(robot) - eye[0], y - eye[1], CAMERA_HEIGHT_M - eye[2])
            yield from self._move(robot, self._base_T_shelf @ transform(place))
            yield from self._see(robot, reader)

    def _move(self, robot: Robot, base_T_hand: Transform) -> Periods:
        """Move the hand on a straight line if that is free, otherwise along a planned path."""
        if self._views:
            try:
                yield from move_straight(robot, base_T_hand, self._held, self._around)
                return
            except Discrepancy as no_line:
                if no_line.cause is not causes.NO_ARM_PATH:
                    raise
        yield from move_to_pose(robot, base_T_hand, self._held, self._around)

    def _see(self, robot: Robot, reader: LabelReader) -> Generator[None, None, None]:
        view = self._last = yield from look(robot, self._base_T_shelf, self._held)
        labels = reader.read(view.image, view.camera, view.camera_T_shelf, view.mask, self._labels)
        self._labels += labels
        seen = find_spines(view.image, view.camera, view.camera_T_shelf, labels, view.mask, self._thicknesses)
        self._views.append(seen)
        self.evidence.pictures[f"view_{len(self._views)}"] = draw_overlay(
            view.image, (), labels, seen.spines, (), view.camera, view.camera_T_shelf
        )

    def _reading(self) -> ShelfReading:
        return fuse_views(self._views, self.fuse)

    def _slot_at(self, left: float, book: Book) -> tuple[Gap, ...]:
        """Return the slot between the last book, whose right side is `left`, and the book end, in the last
        view.
        """
        assert self._last is not None
        right = book_end(self._last, left, book.thickness_mm / 1e3)
        return () if right is None else (Gap(left, right),)

    def _where(self, book: Book, number: CallNumber) -> GapFound | NoGap:
        """Return the interval between labelled books where the book belongs, whether a slot is free there or
        not.
        """
        reading = self._reading()
        self._note(reading)
        widest = max((gap.width for gap in reading.intervals), default=0.0)
        wide = reading._replace(gaps=reading.intervals)
        return find_gap(wide, number, book.thickness_mm / 1e3 - GAP_TOLERANCE_M, widest, self.misplacement)

    def _slot_in(self, seen: GapFound, book: Book, number: CallNumber) -> GapFound | NoGap:
        """Return the slot in an interval that was looked at from both sides."""
        reading = self._reading()
        near = min(
            reading.intervals, key=lambda gap: abs(gap.left + gap.right - 2 * seen.centre), default=None
        )
        if near is None:
            words = "the slot isn't seen any more from nearby"
            return NoGap(words, "slots seen there", 0, 1, at=seen.centre, is_unread=True)
        leaning = self._leaning_in(near, reading.offsets)
        if leaning is not None:
            lean, limit = abs(math.degrees(leaning.lean)), math.degrees(MIN_LEAN_RAD)
            text = f"where it belongs the book {leaning.text or 'there'} leans by {lean:.0f} degrees"
            return NoGap(text, "lean of a label", lean, limit, "deg", seen.centre)
        solid = [(item.left, item.right) for item in reading.books]
        slots = find_slots(self._views, reading.offsets, near, solid)
        return self._find(book, number, slots)

    def _leaning_in(self, interval: Gap, offsets: Sequence[float]) -> Label | None:
        """Return the label of a book that leans within an interval."""
        return next(
            (
                label
                for view, offset in zip(self._views, offsets, strict=True)
                for label in view.leaning
                if interval.right < label.lateral + offset < interval.left
            ),
            None,
        )

    def _find(self, book: Book, number: CallNumber, slots: tuple[Gap, ...]) -> GapFound | NoGap:
        """Return the slot of the book among candidate slots; their widths are scaled by known book
        thicknesses first.
        """
        reading = self._reading()
        self._note(reading)
        scale = scale_of(self._views, self._thicknesses)
        reading = reading._replace(
            gaps=tuple(slot._replace(right=slot.left - slot.width / scale) for slot in slots)
        )
        return find_gap(reading, number, book.thickness_mm / 1e3, misplacement=self.misplacement)

    def _note(self, reading: ShelfReading) -> None:
        read = [str(book.call_number) for book in reading.books if book.call_number is not None]
        self.found(
            views=len(self._views), books_seen=len(reading.books), labels_read=len(read), row=", ".join(read)
        )

    def _conclude(self, model: ModelView, found: GapFound | NoGap) -> None:
        if isinstance(found, NoGap):
            self._decided_by(found)
            read = Measured("Camera", found.what, found.value, found.limit, found.unit)
            raise Discrepancy(found.reason, permanent=True, measured=read, cause=_cause_of(found))
        after, before = (str(number) if number is not None else "" for number in (found.before, found.after))
        self.found(gap_mm=round(1e3 * found.width, 1), gap_at_mm=round(1e3 * found.centre, 1))
        self.found(after=after, before=before, misplaced=", ".join(map(str, found.misplaced)))
        sides = _sides_left_of(found.left, self._reading())
        model.of(Books).slot = Slot(
            self.shelf, found.left, found.right, SLOT_SIDE_SIGMA_M, after, before, sides
        )

    def _decided_by(self, found: NoGap) -> None:
        """Choose as decisive picture the view in which the book's place is nearest to the middle."""
        if found.at is not None:
            middles = [abs((view.left + view.right) / 2 - found.at) for view in self._views]
            self.evidence.decisive = f"view_{1 + int(np.argmin(middles))}"


def _wanted(model: ModelView) -> tuple[Book, CallNumber]:
    """Return the book whose slot is looked for, and its call number."""
    book: Book | None = model.of(Books).book
    if book is None:
        raise Discrepancy("no book has been recognized", permanent=True, cause=causes.NOT_KNOWN)
    number = parse(book.call)
    if number is None:
        raise Discrepancy(
            f"{book.call!r} in the catalogue is not a call number",
            permanent=True,
            cause=book_causes.UNKNOWN_BOOK,
        )
    return book, number


def _thicknesses(catalogue: Catalogue) -> dict[CallNumber, float]:
    """Return the thicknesses by call number in [m], without numbers of books that differ in thickness."""
    known: dict[CallNumber, set[float]] = {}
    for book in catalogue.books:
        if (number := parse(book.call)) is not None:
            known.setdefault(number, set()).add(book.thickness_mm / 1e3)
    return {number: sizes.pop() for number, sizes in known.items() if len(sizes) == 1}


def _sides_left_of(y: float, reading: ShelfReading) -> tuple[float, ...]:
    """Return y of the book sides between y and `LEFT_OF` to its left, in [m]; one of two that touch."""
    sides = {y}
    for side in sorted((side for book in reading.books for side in (book.left, book.right)), key=float):
        if MAX_SIDE_GAP_M < side - y < LEFT_OF and all(abs(side - other) > MAX_SIDE_GAP_M for other in sides):
            sides.add(side)
    return tuple(sorted(sides, reverse=True))


def _end_of_row(reading: ShelfReading, number: CallNumber, no_gap: bool) -> float | None:
    """Return y of the last book's right side in [m]; None unless the wanted book belongs after all others.

    That slot ends at a book end, which is set back: its position is visible only from straight ahead. If
    the last book is misplaced, the slot may also be left of it, unless `no_gap` was found there.
    """
    known = [(book.right, book.call_number) for book in reading.books if book.call_number is not None]
    read = ordered([name for _, name in known])
    if not read or number < read[-1]:
        return None
    right, last = known[-1]
    return right if no_gap or last == read[-1] else None


def _cause_of(gap: NoGap) -> CauseKind:
    """Return why no gap was found: a label could not be read, or the shelf has none."""
    return causes.NOT_SEEN if gap.is_unread else book_causes.NO_SLOT
