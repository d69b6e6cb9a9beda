"""The arm among solid things and rows of books: moving, inserting, pushing."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.saved_state import NotAState
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel

from .arm_contact import FINGERS, FREE, HELD, ArmContact, Touch
from .book import Book
from .insertion import Entrance, Entry
from .row import FORCE_CAP, JAM_FRICTION, PUSH_FRICTION, STIFFNESS, Member, Pusher, Slot, members, push
from .scene import Scene
from .shelf import Shelf

SLOT_FRICTION = 2.0  # of a book that slides in its slot [N]
_WRENCH = np.radians(10.0)  # turned further than this against its slot, a book stops the arm
_FACING = np.cos(np.radians(30.0))
_STEP = 0.02  # that a link goes between two looks: panels and boards are as thick [m]
_GRAZES = 0.003  # [m]
_HALVINGS = 7

Vector = NDArray[np.float64]


class Front(NamedTuple):
    """The shelf that the hand reaches into: its row, and the hand in S."""

    shelf: Shelf
    row: list[Member]
    S_T_hand: Transform


class Hand:
    """Moves the arm of a scene as far as what is solid lets it.

    Quasi-static: the arm stops at the posture where a contact begins, and `scene.hand_force` grows with how
    far it is commanded beyond, 2 N a mm, up to 60 N where its drives give way. A held book in its slot
    yields sideways and aligns with the slot; the hand feels that. A book can be pushed too far into the
    shelf: nothing but friction holds it.
    """

    STATE: ClassVar = {"entered": tuple[str, Slot, bool] | None, "entries": int, "strain": float}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, scene: Scene, arm: ArmModel, seed: int) -> None:
        self.scene, self.arm, self.seed = scene, arm, seed
        self.contact = ArmContact(scene, arm)
        self.entry: Entry | None = None
        self.strain = 0.0
        """How far a hand wrenches the book in its slot, as a share of what stops the arm."""
        self._entrance = Entrance(seed)

    @property
    def entered(self) -> tuple[str, Slot, bool] | None:
        """`entry` in a checkpoint: the shelf by its name."""
        return None if self.entry is None else (self.entry.shelf.name, self.entry.slot, self.entry.admitted)

    @entered.setter
    def entered(self, told: tuple[str, Slot, bool] | None) -> None:
        if told is not None and told[0] not in self.scene.shelves:
            raise NotAState(f"no saved state: there is no shelf {told[0]!r} in this world")
        self.entry = None if told is None else Entry(self.scene.shelves[told[0]], *told[1:])

    @property
    def entries(self) -> int:
        """How often a book entered a slot so far: each has its own luck."""
        return self._entrance.count

    @entries.setter
    def entries(self, count: int) -> None:
        self._entrance.count = count

    def forget_derived(self) -> None:
        """The scene was put elsewhere: forget what was derived from it."""
        self.contact = ArmContact(self.scene, self.arm)

    # Motion

    def move(self, target: Vector) -> frozenset[tuple[str, str]]:
        """Strive for the joint angles `target` (n,) in [rad], coming from `scene.joints`.

        Sets joints, the held book's pose and the force; gives the pairs that touch.
        """
        scene, start = self.scene, self.scene.joints
        front = self.front(target)
        self._follow_entry(front)
        posture, pairs = self._stop_at_solids(start, target)
        pushed, rigid = 0.0, posture is not target
        if front is not None:
            posture, pushed, met = self._stop_at_row(front, start, posture)
            pairs |= met
        scene.joints = posture
        strain = self.strain
        drag = self.carry(start) if scene.held is not None else np.zeros(3)
        if self.strain > max(1.0, strain):
            scene.joints = posture = start
            drag = self.carry(start)
            pairs |= {(HELD, "the sides of its slot")}
        scene.hand_force = self._reaction(target, posture, 0.0 if rigid else pushed) + drag
        return pairs

    def met_at(self, base: Pose2) -> Touch:
        """What of the robot the base there would drive into something, or deeper into it; `FREE` if nothing.

        The base itself is left out: it is a disc (`move_base`).
        """
        there = self.contact.deepest_of_robot(base, self.scene.joints, self._skip)
        if there.depth == 0.0:
            return FREE
        here = self.contact.deepest_of_robot(self.scene.base, self.scene.joints, self._skip)
        return FREE if there.depth <= here.depth else there

    def follow_base(self) -> None:
        """Take along what is held after the base was moved."""
        if self.scene.held is not None:
            self.carry(self.scene.joints)

    def front(self, joints: Vector) -> Front | None:
        """The shelf right before the hand, if the hand points into one."""
        world_T_hand = self.scene.world_T_base @ self.arm.forward(joints)
        for shelf in self.scene.shelves.values():
            S_T_hand = shelf.inverse_pose @ world_T_hand
            x, y, z = S_T_hand[:3, 3]
            near = -0.45 < x < 0.25 and abs(y) < shelf.half_width + 0.05 and -0.1 < z < 0.4
            if near and S_T_hand[0, 0] > _FACING:
                return Front(shelf, members(self.scene, shelf, self.scene.held), S_T_hand)
        return None

    def _follow_entry(self, front: Front | None) -> None:
        book = self.scene.held
        if not isinstance(book, Book) or front is None:
            self.entry = None
            return
        edge = _leading_edge(front, book, self.scene.hand_T_held)
        self.entry = self._entrance.follow(self.entry, front.shelf, front.row, edge, book.thickness)

    def _stop_at_solids(self, start: Vector, target: Vector) -> tuple[Vector, frozenset[tuple[str, str]]]:
        """How far the straight joint line is free; a motion that lessens an overlap always is."""
        free, blocked, there = self._first_hit(start, target)
        if there.depth == 0.0:
            return target, frozenset()
        here = self.contact.deepest_of_arm(start, self._skip)
        if here.depth > 0.0:
            there = self.contact.deepest_of_arm(target, self._skip)
            end = target if there.depth <= here.depth else start
            return end, frozenset({(here.body, here.other)})
        for _ in range(_HALVINGS):
            middle = (free + blocked) / 2
            hit = self.contact.deepest_of_arm(start + middle * (target - start), self._skip)
            free, blocked = (middle, blocked) if hit.depth == 0.0 else (free, middle)
        return start + free * (target - start), frozenset({(there.body, there.other)})

    def _first_hit(self, start: Vector, target: Vector) -> tuple[float, float, Touch]:
        """The first overlap on the line, looked for in steps that no thin board is missed by.

        What the arm only grazes on its way doesn't stop it: nothing here slides along anything. Gives two
        shares of the line, the last one that was free and the one that isn't, and what is met.
        """
        steps = max(1, int(np.ceil(self.contact.travel(start, target) / _STEP)))
        for number in range(1, steps + 1):
            share = number / steps
            there = self.contact.deepest_of_arm(start + share * (target - start), self._skip)
            if there.depth > (0.0 if number == steps else _GRAZES):
                return share - 1.0 / steps, share, there
        return 0.0, 1.0, FREE

    def _skip(self, body: str, other: str) -> bool:
        """Pairs that the row's rules decide instead of rigid geometry."""
        if body in FINGERS:
            tray = self.scene.tray_book()
            return other.startswith("book ") and (tray is None or other != f"book {tray.accession}")
        if body != HELD or self.entry is None:
            return False
        return other.startswith(("book ", "left panel", "right panel"))

    def _stop_at_row(
        self, front: Front, start: Vector, target: Vector
    ) -> tuple[Vector, float, frozenset[tuple[str, str]]]:
        scene, shelf = self.scene, front.shelf
        S_T_base = shelf.inverse_pose @ scene.world_T_base
        before, after = S_T_base @ self.arm.forward(start), S_T_base @ self.arm.forward(target)
        advance, short, force = float(after[0, 3] - before[0, 3]), 0.0, 0.0
        met: set[tuple[str, str]] = set()
        for name, pusher in self._pushers(after):
            # Where the hand stands back already, the pusher's front does too.
            result = push(scene, shelf, front.row, pusher, pusher.lead - max(0.0, advance))
            short = max(short, pusher.lead - result.lead)
            force = max(force, result.force)
            met |= {(name, other) for other in result.met}
        if short <= 0.0:
            return target, 0.0, frozenset(met)
        share = 0.0 if advance <= 0.0 else max(0.0, 1.0 - short / advance)
        return start + share * (target - start), force, frozenset(met)

    def _pushers(self, S_T_hand: Transform) -> list[tuple[str, Pusher]]:
        if self.scene.robot.gripper is None:
            return []
        scene, z, finger = self.scene, float(S_T_hand[2, 3]), self.scene.robot.finger_shape
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
        if isinstance(scene.held, Book) and self.entry is not None and not self.entry.admitted:
            found.append((HELD, self._jammed(S_T_hand, scene.held)))
        return found

    def _jammed(self, S_T_hand: Transform, book: Book) -> Pusher:
        pose = S_T_hand @ self.scene.hand_T_held
        edge = pose @ np.array([book.depth, 0.0, 0.0, 1.0])
        half, entry = book.thickness / 2, self.entry
        right, left = float(edge[1]) - half, float(edge[1]) + half
        if entry is not None and entry.slot.width > 0.0:
            # It stands against the nearer side of the slot, however little it overlaps.
            if edge[1] > entry.slot.middle:
                left = max(left, entry.slot.left + 0.002)
            else:
                right = min(right, entry.slot.right - 0.002)
        return Pusher(float(edge[0]), right, left, float(edge[2]), float(edge[2]) + book.height, JAM_FRICTION)

    def _reaction(self, target: Vector, posture: Vector, pushed: float) -> Vector:
        """Force in the hand frame from how far the arm is commanded beyond where it stands."""
        if posture is target:
            return np.zeros(3)
        base_T_hand = self.arm.forward(posture)
        beyond = self.arm.forward(target)[:3, 3] - base_T_hand[:3, 3]
        force = -STIFFNESS * (base_T_hand[:3, :3].T @ beyond)
        if pushed > 0.0:
            force[0] = -pushed
        size = float(np.linalg.norm(force))
        return np.asarray(force * min(1.0, FORCE_CAP / size) if size > 0.0 else force)

    def carry(self, start: Vector) -> Vector:
        """Place what is held with the hand; a book in its slot aligns. Gives the slot's force on the hand."""
        scene, book = self.scene, self.scene.held
        assert book is not None
        world_T_hand = scene.world_T_base @ self.arm.forward(scene.joints)
        book.pose = world_T_hand @ scene.hand_T_held
        self.strain = 0.0
        if self.entry is None or not self.entry.admitted or not isinstance(book, Book):
            return np.zeros(3)
        shelf, slot = self.entry.shelf, self.entry.slot
        rigid = shelf.inverse_pose @ book.pose
        half = book.thickness / 2
        lateral = float(
            np.clip(rigid[1, 3], min(slot.right + half, slot.middle), max(slot.left - half, slot.middle))
        )
        book.pose = shelf.pose @ transform((rigid[0, 3], lateral, max(0.0, rigid[2, 3])))
        beside, turned = abs(lateral - rigid[1, 3]), float(np.arccos(np.clip(rigid[0, 0], -1.0, 1.0)))
        self.strain = float(max(beside / (FORCE_CAP / STIFFNESS), turned / _WRENCH))
        moved = self.arm.forward(scene.joints)[0, 3] - self.arm.forward(start)[0, 3]
        force = np.array([-SLOT_FRICTION if moved > 1e-4 else 0.0, STIFFNESS * (lateral - rigid[1, 3]), 0.0])
        force[1] = np.clip(force[1], -FORCE_CAP, FORCE_CAP)
        return np.asarray(world_T_hand[:3, :3].T @ shelf.pose[:3, :3] @ force)


def _leading_edge(front: Front, book: Book, hand_T_book: Transform) -> tuple[float, float, float]:
    pose = front.S_T_hand @ hand_T_book
    edge = pose @ np.array([book.depth, 0.0, 0.0, 1.0])
    return float(edge[0]), float(edge[1]), float(np.arctan2(pose[1, 0], pose[0, 0]))
