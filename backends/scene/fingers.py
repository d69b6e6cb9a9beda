"""The two fingers: gripping, holding, letting go."""

from __future__ import annotations

import numpy as np

from robotics.geometry.transform import inverse, transform

from .book import Book, Rest
from .hand import Hand
from .insertion import Entry
from .putting_down import put_down
from .row import Slot, members
from .shelf import Shelf

PAD = 0.05  # of the fingers' length that is padded, up to the tips [m]
_BITE = 0.005  # a book must reach this deep between the pads to be held
_LETS_GO = 0.001  # opening beyond the book's thickness at which it is free


class Fingers:
    """Open and close about books.

    A book between closing pads stops and aligns with them, centred; its depth and height in the hand stay.
    Opened 1 mm wider than the book, they let it go. Between neighbours in a row they have no room to open.
    """

    def __init__(self, hand: Hand) -> None:
        self._hand, self._scene = hand, hand.scene
        self._shape = hand.scene.robot.finger_shape

    def set_width(self, width: float) -> None:
        """Bring the finger pads to that opening in [m]; what stands between them stops and holds it."""
        scene = self._scene
        if scene.held is None and width < scene.width:
            book = self._between()
            if book is not None and width <= book.thickness:
                self._grip(book)
                return
        if scene.held is not None:
            if width <= scene.held.thickness + _LETS_GO:
                scene.width = max(width, scene.held.thickness)
                return
            self._let_go(scene.held)
        scene.width = min(width, max(scene.width, self._room()))

    def _between(self) -> Book | None:
        """The book that closing fingers meet."""
        scene, shape = self._scene, self._shape
        hand_T_world = inverse(scene.world_T("hand"))
        for book in scene.books.values():
            if book.rest is Rest.FLOOR:
                continue
            pose = hand_T_world @ book.pose
            x, y, z = pose[:3, 3]
            inside = x < shape.tip - _BITE and x + book.depth > shape.tip - PAD and pose[0, 0] > 0.9
            level = z < shape.height / 2 and z + book.height > -shape.height / 2
            if inside and level and abs(y) + book.thickness / 2 < scene.width / 2 + shape.thickness:
                return book
        return None

    def _grip(self, book: Book) -> None:
        """Covers align with the pads: centred, turned to the hand; depth and height stay."""
        scene = self._scene
        scene.width = book.thickness
        world_T_hand = scene.world_T("hand")
        before = inverse(world_T_hand) @ book.pose
        pitch = float(np.arctan2(-before[2, 0], before[0, 0]))
        scene.hand_T_book = transform((before[0, 3], 0.0, before[2, 3]), (0.0, pitch, 0.0))
        if book.rest is Rest.SHELF and book.shelf is not None:
            self._hand.entry = self._slot_of(book, scene.shelves[book.shelf])
        book.rest, book.shelf, scene.held = Rest.HAND, None, book
        scene.changes += 1
        self._hand.carry(scene.joints)

    def _slot_of(self, book: Book, shelf: Shelf) -> Entry | None:
        """A book gripped in its slot is in it still."""
        row = members(self._scene, shelf, book)
        y = float((shelf.inverse_pose @ book.pose)[1, 3])
        half = book.thickness / 2
        right = max((m for m in row if m.left <= y - half + 1e-4), key=lambda m: m.left)
        left = min((m for m in row if m.right >= y + half - 1e-4), key=lambda m: m.right)
        edge = float((shelf.inverse_pose @ book.pose)[0, 3]) + book.depth
        front = min(right.front, left.front)
        return Entry(shelf, Slot(right.left, left.right, front), True) if edge > front else None

    def _let_go(self, book: Book) -> None:
        slot = self._hand.entry.slot if self._hand.entry is not None and self._hand.entry.admitted else None
        self._scene.held, self._hand.entry = None, None
        put_down(self._scene, book, slot)

    def _room(self) -> float:
        """How far the fingers can open: neighbours in the row stop them once the tips are between them."""
        front = self._hand.front(self._scene.joints)
        if front is None:
            return np.inf
        tip = front.S_T_hand @ np.array([self._shape.tip, 0.0, 0.0, 1.0])
        half = self._scene.width / 2
        sides = [m for m in front.row if m.front < tip[0] - 0.001 and tip[2] < m.top]
        left = min((m.right - tip[1] for m in sides if m.right >= tip[1] + half - 0.001), default=np.inf)
        right = min((tip[1] - m.left for m in sides if m.left <= tip[1] - half + 0.001), default=np.inf)
        return float(max(0.0, 2 * (min(left, right) - self._shape.thickness)))
