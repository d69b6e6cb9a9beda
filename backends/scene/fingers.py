"""The two fingers: gripping, holding, letting go."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.geometry.transform import inverse, transform

from .block import Block
from .block_support import put_down_block
from .book import Book, Rest
from .hand import Hand
from .insertion import Entry
from .keyed_noise import keyed
from .putting_down import put_down
from .row import Slot, members
from .shelf import Shelf
from .thing import Thing

PAD = 0.05  # of the fingers' length that is padded, up to the tips [m]
_BITE = 0.005  # a book must reach this deep between the pads to be held
_LETS_GO = 0.001  # opening beyond a thing's thickness at which it is free
_SQUARE = np.cos(np.radians(15.0))  # turned further than this against the pads, a block isn't gripped


class Fingers:
    """Open and close about books and blocks.

    What stands between closing pads stops and aligns with them, centred; along the pads it stays where it is.
    Opened 1 mm wider, they let it go. Between neighbours in a row they have no room to open.
    """

    def __init__(self, hand: Hand) -> None:
        self._hand, self._scene = hand, hand.scene
        self._shape = hand.scene.robot.finger_shape

    def set_width(self, width: float) -> None:
        """Bring the finger pads to that opening in [m]; what stands between them stops and holds it."""
        scene = self._scene
        if scene.held is None and width < scene.width:
            thing = self._between()
            if thing is not None and width <= self._thickness(thing):
                self._grip(thing)
                return
        if scene.held is not None:
            thick = self._thickness(scene.held)
            if width <= thick + _LETS_GO:
                scene.width = max(width, thick)
                return
            self._let_go(scene.held)
        scene.width = min(width, max(scene.width, self._room()))

    def _thickness(self, thing: Thing) -> float:
        """Between the pads, in [m]."""
        if isinstance(thing, Book):
            return thing.thickness
        return thing.size[self._across(thing)]

    def _across(self, thing: Thing) -> int:
        """Which axis of a thing lies most along the closing direction."""
        closing = self._scene.world_T("hand")[:3, 1]
        return int(np.argmax(np.abs(thing.pose[:3, :3].T @ closing)))

    def _between(self) -> Thing | None:
        """What closing fingers meet."""
        return self._book_between() or self._block_between()

    def _block_between(self) -> Block | None:
        scene, shape = self._scene, self._shape
        hand_T_world = inverse(scene.world_T("hand"))
        reach = np.array([PAD / 2, scene.width / 2 + shape.thickness, shape.height / 2])
        for block in scene.blocks.values():
            if block.rest is Rest.FLOOR:
                continue
            middle = hand_T_world @ block.pose @ block.thing_T_middle
            axis = self._across(block)
            turned = abs(float(middle[1, axis]))
            half = np.abs(middle[:3, :3]) @ np.array(block.size) / 2
            near = np.abs(middle[:3, 3] - (shape.tip - PAD / 2, 0.0, 0.0)) < reach + half - _BITE
            inside = abs(middle[1, 3]) + block.size[axis] / 2 < scene.width / 2 + shape.thickness
            if turned > _SQUARE and near[0] and near[2] and inside:
                return block
        return None

    def _book_between(self) -> Book | None:
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

    def _grip(self, thing: Thing) -> None:
        if isinstance(thing, Book):
            self._grip_book(thing)
        elif isinstance(thing, Block):
            self._grip_block(thing)
        self._scene.changes += 1
        self._hand.carry(self._scene.joints)

    def _grip_block(self, block: Block) -> None:
        """Its sides align with the pads, and it slides between their middle; along the pads it stays."""
        scene = self._scene
        world_T_hand = scene.world_T("hand")
        axis = self._across(block)
        scene.width = block.size[axis]
        hand_T_middle = inverse(world_T_hand) @ block.pose @ block.thing_T_middle
        side = hand_T_middle[:3, axis]
        pads = np.array([0.0, np.sign(side[1]), 0.0])
        turn = Rotation.align_vectors(pads[None], side[None])[0].as_matrix()
        hand_T_middle[:3, :3] = turn @ hand_T_middle[:3, :3]
        hand_T_middle[1, 3] = 0.0
        scene.hand_T_held = hand_T_middle @ inverse(block.thing_T_middle)
        block.rest, scene.held = Rest.HAND, block

    def _grip_book(self, book: Book) -> None:
        """Covers align with the pads: centred, turned to the hand; depth and height stay."""
        scene = self._scene
        scene.width = book.thickness
        world_T_hand = scene.world_T("hand")
        before = inverse(world_T_hand) @ book.pose
        pitch = float(np.arctan2(-before[2, 0], before[0, 0]))
        scene.hand_T_held = transform((before[0, 3], 0.0, before[2, 3]), (0.0, pitch, 0.0))
        if book.rest is Rest.SHELF and book.shelf is not None:
            self._hand.entry = self._slot_of(book, scene.shelves[book.shelf])
        book.rest, book.shelf, scene.held = Rest.HAND, None, book

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

    def _let_go(self, thing: Thing) -> None:
        slot = self._hand.entry.slot if self._hand.entry is not None and self._hand.entry.admitted else None
        self._scene.held, self._hand.entry = None, None
        if isinstance(thing, Book):
            put_down(self._scene, thing, slot, self._left_aside(thing))
        elif isinstance(thing, Block):
            put_down_block(self._scene, thing)

    def _left_aside(self, book: Book) -> float:
        """How far to the left a book leans as the second finger leaves it, in [rad]."""
        spread = math.radians(self._scene.robot.errors.book_lean_deg)
        instant = round(self._scene.time / self._scene.robot.period_s)
        return spread * float(keyed(self._hand.seed, f"{book.name} let go", instant).standard_normal())

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
