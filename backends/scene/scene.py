"""The true state of a simulated world. Only evaluation and the simulation itself read it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.plain_values import Kinds
from handcart.backends.robot_file import RobotFile
from handcart.backends.saved_state import NotAState
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.arm_model import ArmModel

from .block import Block
from .book import Book, Rest
from .keyed_noise import keyed
from .mark import Mark
from .shelf import Shelf
from .solids import THE_GROUND, FloorPlan, Solid, of_furniture, of_table, of_wall
from .suspension import leaning
from .thing import Thing
from .world_file import BookSpec, StationSpec, WorldFile

SPINE_ON_TRAY = 0.02  # from the tray's rear to the book's spine, as a person sets it down [m]
PROTRUSION = 0.003  # spines stand this much before or behind the board's front edge at most [m]


class Contact(NamedTuple):
    """The beginning of a contact."""

    time: float
    """[s]"""
    body: str
    """What of the robot: "base", a link, "held book", "fingers"."""
    other: str
    """What it ran into."""


class StandingBook(NamedTuple):
    """How a book stands on a shelf, in S."""

    book: Book
    lateral: float
    """y of the middle of its spine, in [m]."""
    front: float
    """x of its spine, in [m]: below zero, it is proud."""
    tilt: float
    """Of its height against the vertical, in [rad]."""
    yaw: float
    """Of its depth against the shelf's, in [rad]."""
    lean: float
    """Sideways, to the left, in [rad]."""

    @property
    def sides(self) -> tuple[float, float]:
        """y of its rightmost and its leftmost point, in [m]."""
        half = self.book.thickness / 2 * math.cos(self.lean)
        over = self.book.height * math.sin(self.lean)
        return self.lateral - half + min(0.0, over), self.lateral + half + max(0.0, over)


@dataclass(eq=False)
class Scene:
    """World and robot as they truly are.

    `base` is world_T_base; `joints` (n,) in [rad]; `width` the opening between the finger pads in [m];
    `hand_force` (3,) in [N] in the hand frame, without noise; `contacts` all that the robot ran into.
    """

    STATE: ClassVar[Kinds] = {
        "base": Pose2,
        "tilted_base": Transform | None,
        "joints": NDArray[np.float64],
        "width": float,
        "time": float,
        "books": dict[int, Book],
        "blocks": dict[str, Block],
        "held_name": str | None,
        "hand_T_held": Transform,
        "lean": tuple[float, float],
        "base_T_tray_book": Transform,
        "hand_force": NDArray[np.float64],
        "contacts": list[Contact],
        "touching": frozenset[tuple[str, str]],
        "to_come": list[BookSpec],
        "loaded": int,
        "changes": int,
    }
    """Attributes that a checkpoint keeps, with their types."""

    robot: RobotFile
    arm: ArmModel | None
    shelves: dict[str, Shelf]
    solids: tuple[Solid, ...]
    books: dict[int, Book]
    base: Pose2
    joints: NDArray[np.float64]
    width: float
    blocks: dict[str, Block] = field(default_factory=dict)
    marks: tuple[Mark, ...] = ()
    time: float = 0.0
    lean: tuple[float, float] = (0.0, 0.0)
    """Roll and pitch of the base on its suspension, in [rad]."""
    held: Thing | None = None
    hand_T_held: Transform = field(default_factory=lambda: np.eye(4))
    base_T_tray_book: Transform = field(default_factory=lambda: np.eye(4))
    hand_force: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    contacts: list[Contact] = field(default_factory=list)
    touching: frozenset[tuple[str, str]] = frozenset()
    """What touches in this period: pairs as in `Contact`."""
    to_come: list[BookSpec] = field(default_factory=list)
    """Books that a person still has for the robot."""
    open_ground: bool = False
    """Whether it stands outdoors: what is let go stands on the ground."""
    total_station: StationSpec | None = None
    """What measures, for evaluation, where the hand is."""
    loaded: int = 0
    """How many sensors its magazine has given so far."""
    tilted_base: Transform | None = None
    """world_T_base (4, 4) where physics lets the base tilt; None: it stands level."""
    changes: int = 0
    """Counts the times that a book was moved: what is derived from their poses asks it."""

    def __post_init__(self) -> None:
        self.body_plan = FloorPlan(self.solids, 0.02, self.robot.body_height)
        self.full_plan = FloorPlan(self.solids, 0.02, 2.0)

    @property
    def held_name(self) -> str | None:
        """What is held, by its name: a thing of the world, not a copy of it."""
        return None if self.held is None else self.held.name

    @held_name.setter
    def held_name(self, name: str | None) -> None:
        self.held = self.thing_named(name)

    def thing_named(self, name: str | None) -> Thing | None:
        """A book or block by its name; None has none. Raises `NotAState` where there is no such thing."""
        found = next((thing for thing in self.things() if thing.name == name), None)
        if name is not None and found is None:
            raise NotAState(f"no saved state: there is no {name!r} in this world")
        return found

    # Where things are

    @property
    def world_T_base(self) -> Transform:
        """(4, 4)."""
        return self.leaning_at(self.base) if self.tilted_base is None else self.tilted_base

    def leaning_at(self, base: Pose2) -> Transform:
        """world_T_base (4, 4) of a base elsewhere that leans as it does now, on its suspension."""
        pose = base.lift()
        return pose if self.lean == (0.0, 0.0) else pose @ leaning(self.lean, self.robot.errors.lean_pivot_m)

    def world_T(self, frame: str) -> Transform:
        """True pose (4, 4) of a frame of the robot."""
        if self.arm is None:
            raise ValueError("the robot has no arm")
        return self.world_T_base @ self.arm.forward(self.joints, frame)

    def book_pose(self, accession: int) -> Transform:
        """world_T_book (4, 4); its frame is that of `Book`."""
        return self.books[accession].pose

    def shelf_books(self, shelf: str) -> list[StandingBook]:
        """What stands on a shelf, from left to right."""
        frame = self.shelves[shelf].inverse_pose
        standing = []
        for book in self.books.values():
            if book.rest is Rest.SHELF and book.shelf == shelf:
                pose = frame @ book.pose
                yaw = float(np.arctan2(pose[1, 0], pose[0, 0]))
                lean = -float(np.arctan2(pose[2, 1], pose[2, 2]))
                y, x = float(pose[1, 3]), float(pose[0, 3])
                standing.append(StandingBook(book, y, x, book.tilt(), yaw, lean))
        return sorted(standing, key=lambda each: -each.lateral)

    def tray_book(self) -> Book | None:
        """What stands on the tray."""
        return next((book for book in self.books.values() if book.rest is Rest.TRAY), None)

    def things(self) -> list[Thing]:
        """All books and blocks that are there."""
        return [*self.books.values(), *self.blocks.values()]

    def riding(self) -> list[Thing]:
        """What stands on the robot."""
        return [thing for thing in self.things() if thing.rest is Rest.TRAY]

    # What changes it

    def move_base(self, base: Pose2) -> None:
        """Put the base elsewhere, with what stands on its tray; what is held is the hand's."""
        self.base = base
        self._carry_along()

    def lean_to(self, lean: tuple[float, float]) -> None:
        """Let the base lean otherwise: roll and pitch in [rad]."""
        if lean != self.lean:
            self.lean = lean
            self._carry_along()

    def _carry_along(self) -> None:
        book = self.tray_book()
        if book is not None:
            book.pose = self.world_T_base @ self.base_T_tray_book
            self.changes += 1
        for block in self.blocks.values():
            if block.rest is Rest.TRAY:
                block.pose = self.world_T_base @ block.base_T_block
                self.changes += 1

    def touch(self, pairs: frozenset[tuple[str, str]]) -> None:
        """Note what touches in this period; what didn't before is a new contact."""
        for body, other in sorted(pairs - self.touching):
            self.contacts.append(Contact(self.time, body, other))
        self.touching = pairs


def build_scene(robot: RobotFile, world: WorldFile, seed: int) -> Scene:
    """The world at first: robot and tray's book set down by a person, spines not quite in line."""
    assert world.map is None, "load_world puts what the map shows among the furniture"
    shelves = {spec.name: Shelf(spec) for spec in world.shelves}
    solids = [of_wall(wall, i) for i, wall in enumerate(world.walls)]
    solids += [of_furniture(piece) for piece in (*world.furniture, *world.surprises)]
    solids += [part for table in world.tables for part in of_table(table)]
    solids += [THE_GROUND] if world.ground is not None else []
    solids += [Solid(part) for shelf in shelves.values() for part in shelf.parts().values()]
    books = {book.accession: book for shelf in shelves.values() for book in _standing(shelf, seed)}
    arm = None if robot.arm is None else robot.arm_model()
    joints = np.zeros(0) if robot.arm is None else np.array(robot.posture("home"))
    width = 0.0 if robot.gripper is None else robot.gripper.opening_mm / 1e3
    scene = Scene(robot, arm, shelves, tuple(solids), books, _start(robot, world, seed), joints, width)
    if world.tray is not None and robot.has_tray:
        set_on_tray(scene, world.tray, seed)
    scene.total_station = world.total_station
    scene.open_ground = world.ground is not None
    scene.to_come += world.handed_over
    scene.marks = tuple(Mark(spec) for spec in world.marks)
    set_blocks(scene, world, seed)
    return scene


def _start(robot: RobotFile, world: WorldFile, seed: int) -> Pose2:
    dx, dy, turn = keyed(seed, "start").standard_normal(3)
    error = robot.errors.start_mm / 1e3
    heading = np.radians(world.start.heading_deg + robot.errors.start_deg * turn)
    x, y = world.start.x_m + error * dx, world.start.y_m + error * dy
    return Pose2(float(x), float(y), float(heading))


def _standing(shelf: Shelf, seed: int) -> list[Book]:
    rng = keyed(seed, f"row of {shelf.name}")
    return [
        Book(
            shelf.pose @ transform((rng.uniform(-PROTRUSION, PROTRUSION), y, 0.0)),
            Rest.SHELF,
            spec,
            shelf.name,
        )
        for spec, y in shelf.standing()
    ]


def set_on_tray(scene: Scene, spec: BookSpec, seed: int, number: int = 0) -> None:
    """A person puts the book with this number down on the tray, not quite in its place."""
    dx, dy, turn = keyed(seed, f"tray {number}" if number else "tray").standard_normal(3)
    place = scene.robot.errors.book_place_mm / 1e3
    yaw = np.radians(scene.robot.errors.book_turn_deg * turn)
    tray = scene.robot.tray_shape
    spine = (tray.rear + SPINE_ON_TRAY + place * dx, tray.middle[1] + place * dy, tray.top)
    scene.base_T_tray_book = transform(spine, (0.0, 0.0, yaw))
    pose = scene.world_T_base @ scene.base_T_tray_book
    scene.books[spec.accession] = Book(pose, Rest.TRAY, spec)
    scene.changes += 1


def set_blocks(scene: Scene, world: WorldFile, seed: int) -> None:
    """A person sets the blocks down, on tables and on the robot's own, not quite in their places."""
    errors = scene.robot.errors
    for spec in world.blocks:
        dx, dy, turn = keyed(seed, f"block {spec.name}").standard_normal(3)
        place = errors.block_place_mm / 1e3
        yaw = np.radians(spec.heading_deg + errors.block_turn_deg * turn)
        stands = transform((spec.x_m + place * dx, spec.y_m + place * dy, spec.height_m), (0.0, 0.0, yaw))
        if spec.on == "robot":
            pose = scene.world_T_base @ stands
            scene.blocks[spec.name] = Block(pose, Rest.TRAY, spec, stands)
        else:
            scene.blocks[spec.name] = Block(stands, Rest.TABLE, spec)
    scene.changes += 1
