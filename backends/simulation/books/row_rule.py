"""A hand that reaches into a row of books: pushing, inserting."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.body.arm_contact import FINGER_LINKS, LOAD_NAME
from handcart.backends.simulation.world.hand_rule import ARM_STIFFNESS_N_M, FORCE_CAP, HandRule, Met
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .book import SimulatedBook
from .books_there import BooksThere
from .insertion import Entrance, Entry
from .row import JAM_FRICTION, PUSH_FRICTION, FreeInterval, Member, Pusher, members, push
from .shelf import SimulatedShelf

SLOT_FRICTION = 2.0  # of a book that slides in its slot [N]
_WRENCH = np.radians(10.0)  # turned further than this against its slot, a book stops the arm
_FACING = np.cos(np.radians(30.0))


class Front(NamedTuple):
    """State when the hand is in front of a shelf, with the shelf, its row of books, and the hand's pose (4,
    4) in the shelf frame S.
    """

    shelf: SimulatedShelf
    row: list[Member]
    S_T_hand: Transform


class RowRule(HandRule):
    """Rule for contacts of the hand and a held book with a row of books on a shelf.

    Books in the row slide back where they are pushed. A held book either enters a slot or jams at its front.
    In the slot it yields sideways and aligns with the slot, which exerts a force on the hand. A book can be
    pushed too far into the shelf, because only friction holds it.
    """

    STATE: ClassVar[Kinds] = {
        "entered": tuple[str, FreeInterval, bool] | None,
        "entries": int,
        "strain": float,
    }
    strained_by = "the sides of its slot"

    def __init__(self, books: BooksThere, arm: ArmModel) -> None:
        self._books, self._scene, self._arm = books, books.scene, arm
        self.entry: Entry | None = None
        self._front: Front | None = None
        self._row: tuple[object, list[Member]] | None = None
        """Inputs of the cached row, and the row that the hand reaches into."""
        self._entrance = Entrance(books.seed)

    @property
    def entered(self) -> tuple[str, FreeInterval, bool] | None:
        """State of a book's insertion for checkpoints, with the shelf's name, the slot, and True if the book
        enters the slot.

        None if no book's leading edge has passed the front of a row.
        """
        return None if self.entry is None else (self.entry.shelf.name, self.entry.slot, self.entry.admitted)

    @entered.setter
    def entered(self, kept: tuple[str, FreeInterval, bool] | None) -> None:
        if kept is not None and kept[0] not in self._books.shelves:
            raise NotAState(f"no saved state: this world lacks the shelf {kept[0]!r}")
        self._row = None
        self.entry = None if kept is None else Entry(self._books.shelves[kept[0]], *kept[1:])

    @property
    def entries(self) -> int:
        """Number of books so far that a hand began to insert into slots; it selects the random numbers of the
        next insertion.
        """
        return self._entrance.count

    @entries.setter
    def entries(self, count: int) -> None:
        self._entrance.count = count

    @override
    def aim(self, joints: FloatArray) -> None:
        self._front = self.front(joints)
        self._follow_entry(self._front)

    @override
    def decides(self, body: str, other: str) -> bool:
        if body in FINGER_LINKS:
            tray = self._books.tray_book()
            return other.startswith("book ") and (tray is None or other != f"book {tray.accession}")
        if body != LOAD_NAME or self.entry is None:
            return False
        return other.startswith(("book ", "left panel", "right panel"))

    @override
    def meet(self, start: FloatArray, joints: FloatArray) -> Met:
        return Met(joints) if self._front is None else self._stop_at_row(self._front, start, joints)

    def carry(self, thing: Thing, world_T_hand: Transform, start: FloatArray) -> FloatArray:
        """Turn and shift a held book in the hand, so that it is parallel to the slot that it is in and within
        the slot's width.

        Args:
            thing: the held object.
            world_T_hand: (4, 4) pose of the hand.
            start: (n,) joints at the start of the period, in [rad] or [m].

        Returns:
            Force (3,) of the slot on the hand, in the hand frame, in [N]; zero outside a slot.
        """
        self.strain = 0.0
        if self.entry is None or not self.entry.admitted or not isinstance(thing, SimulatedBook):
            return np.zeros(3)
        shelf, slot = self.entry.shelf, self.entry.slot
        rigid = shelf.inverse_pose @ thing.pose
        half = thing.thickness / 2
        lateral = float(
            np.clip(rigid[1, 3], min(slot.right + half, slot.middle), max(slot.left - half, slot.middle))
        )
        thing.pose = shelf.pose @ transform((rigid[0, 3], lateral, max(0.0, rigid[2, 3])))
        beside, turned = abs(lateral - rigid[1, 3]), float(np.arccos(np.clip(rigid[0, 0], -1.0, 1.0)))
        self.strain = float(max(beside / (FORCE_CAP / ARM_STIFFNESS_N_M), turned / _WRENCH))
        moved = self._arm.forward(self._scene.joints)[0, 3] - self._arm.forward(start)[0, 3]
        force = np.array(
            [-SLOT_FRICTION if moved > 1e-4 else 0.0, ARM_STIFFNESS_N_M * (lateral - rigid[1, 3]), 0.0]
        )
        force[1] = np.clip(force[1], -FORCE_CAP, FORCE_CAP)
        return np.asarray(world_T_hand[:3, :3].T @ shelf.pose[:3, :3] @ force)

    def room(self) -> float:
        """Return the largest possible opening of the fingers, in [m]; infinity if no object limits it.

        Books in the row limit the opening if the fingertips are between them.
        """
        front, finger = self.front(self._scene.joints), self._scene.robot.finger_shape
        if front is None:
            return np.inf
        tip = front.S_T_hand @ np.array([finger.tip, 0.0, 0.0, 1.0])
        half = self._scene.width / 2
        sides = [m for m in front.row if m.front < tip[0] - 0.001 and tip[2] < m.top]
        left = min((m.right - tip[1] for m in sides if m.right >= tip[1] + half - 0.001), default=np.inf)
        right = min((tip[1] - m.left for m in sides if m.left <= tip[1] - half + 0.001), default=np.inf)
        return float(max(0.0, 2 * (min(left, right) - finger.thickness)))

    def gripped(self, thing: Thing) -> None:
        """Record that the fingers have gripped a thing; a book that stands on a shelf is then treated as
        inserted into its slot.
        """
        if isinstance(thing, SimulatedBook) and thing.rest is Rest.TABLE and thing.shelf is not None:
            self.entry = self._slot_of(thing, self._books.shelves[thing.shelf])

    def left(self) -> FreeInterval | None:
        """Return the slot of the book that the fingers just released, and forget that it was being inserted.

        None if the book was in no slot.
        """
        slot = self.entry.slot if self.entry is not None and self.entry.admitted else None
        self.entry = None
        return slot

    def front(self, joints: FloatArray) -> Front | None:
        """Return the shelf in front of the hand, with its row; None if the hand is not close to a shelf and
        directed at it.

        Args:
            joints: (n,) posture of the arm, in [rad] or [m].
        """
        world_T_hand = self._scene.world_T_base @ self._arm.forward(joints)
        for shelf in self._books.shelves.values():
            S_T_hand = shelf.inverse_pose @ world_T_hand
            x, y, z = S_T_hand[:3, 3]
            near = -0.45 < x < 0.25 and abs(y) < shelf.half_width + 0.05 and -0.1 < z < 0.4
            if near and S_T_hand[0, 0] > _FACING:
                return Front(shelf, self._members(shelf), S_T_hand)
        return None

    def _members(self, shelf: SimulatedShelf) -> list[Member]:
        """Return the row on a shelf, built again after something was moved."""
        key = self._scene.changes, self._scene.held, shelf
        if self._row is None or self._row[0] != key:
            self._row = key, members(self._books, shelf, self._scene.held)
        return self._row[1]

    def _follow_entry(self, front: Front | None) -> None:
        book = self._scene.held
        if not isinstance(book, SimulatedBook) or front is None:
            self.entry = None
            return
        edge = _leading_edge(front, book, self._scene.hand_T_held)
        self.entry = self._entrance.follow(self.entry, front.shelf, front.row, edge, book.thickness)

    def _slot_of(self, book: SimulatedBook, shelf: SimulatedShelf) -> Entry | None:
        row = members(self._books, shelf, book)
        y = float((shelf.inverse_pose @ book.pose)[1, 3])
        half = book.thickness / 2
        right = max((m for m in row if m.left <= y - half + 1e-4), key=lambda m: m.left)
        left = min((m for m in row if m.right >= y + half - 1e-4), key=lambda m: m.right)
        edge = float((shelf.inverse_pose @ book.pose)[0, 3]) + book.depth
        front = min(right.front, left.front)
        return Entry(shelf, FreeInterval(right.left, left.right, front), True) if edge > front else None

    def _stop_at_row(self, front: Front, start: FloatArray, target: FloatArray) -> Met:
        scene, shelf = self._scene, front.shelf
        S_T_base = shelf.inverse_pose @ scene.world_T_base
        before, after = S_T_base @ self._arm.forward(start), S_T_base @ self._arm.forward(target)
        advance, short, force = float(after[0, 3] - before[0, 3]), 0.0, 0.0
        met: set[tuple[str, str]] = set()
        for name, pusher in self._pushers(after):
            # A hand that was pushed back has its pusher's front there, too.
            result = push(self._books, shelf, front.row, pusher, pusher.lead - max(0.0, advance))
            short = max(short, pusher.lead - result.lead)
            force = max(force, result.force)
            met |= {(name, other) for other in result.met}
        if short <= 0.0:
            return Met(target, 0.0, frozenset(met))
        share = 0.0 if advance <= 0.0 else max(0.0, 1.0 - short / advance)
        return Met(start + share * (target - start), force, frozenset(met))

    def _pushers(self, S_T_hand: Transform) -> list[tuple[str, Pusher]]:
        if self._scene.robot.gripper is None:
            return []
        scene, z, finger = self._scene, float(S_T_hand[2, 3]), self._scene.robot.finger_shape
        inner, outer = scene.width / 2, scene.width / 2 + finger.thickness
        spans = [(-outer, -inner), (inner, outer)]
        if scene.width < 2 * finger.thickness:
            spans = [(-outer, outer)]
        low, high = z - finger.height / 2, z + finger.height / 2
        found = []
        for right, left in spans:
            ends = [S_T_hand @ np.array([finger.tip, y, 0.0, 1.0]) for y in (right, left)]
            lead = float(max(ends[0][0], ends[1][0]))
            span = (float(ends[0][1]), float(ends[1][1]))
            found.append(("fingers", Pusher(lead, *span, low, high, PUSH_FRICTION)))
        if isinstance(scene.held, SimulatedBook) and self.entry is not None and not self.entry.admitted:
            found.append((LOAD_NAME, self._jammed(S_T_hand, scene.held)))
        return found

    def _jammed(self, S_T_hand: Transform, book: SimulatedBook) -> Pusher:
        pose = S_T_hand @ self._scene.hand_T_held
        edge = pose @ np.array([book.depth, 0.0, 0.0, 1.0])
        half, entry = book.thickness / 2, self.entry
        right, left = float(edge[1]) - half, float(edge[1]) + half
        if entry is not None and entry.slot.width > 0.0:
            # It touches the nearer side of the slot, however small the overlap is.
            if edge[1] > entry.slot.middle:
                left = max(left, entry.slot.left + 0.002)
            else:
                right = min(right, entry.slot.right - 0.002)
        return Pusher(float(edge[0]), right, left, float(edge[2]), float(edge[2]) + book.height, JAM_FRICTION)


def _leading_edge(front: Front, book: SimulatedBook, hand_T_book: Transform) -> tuple[float, float, float]:
    pose = front.S_T_hand @ hand_T_book
    edge = pose @ np.array([book.depth, 0.0, 0.0, 1.0])
    return float(edge[0]), float(edge[1]), float(np.arctan2(pose[1, 0], pose[0, 0]))
