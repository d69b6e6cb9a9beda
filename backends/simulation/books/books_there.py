"""Books and shelves of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from typing_extensions import override

from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.world.props import Props
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.solids import Solid
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform

from .book import SimulatedBook
from .shelf import SimulatedShelf
from .spec import BookSpec, BooksSection
from .standing_book import StandingBook, leaned

SPINE_ON_TRAY = 0.02  # from the tray's rear to the book's spine, as a person sets it down [m]
MAX_SPINE_OFFSET_M = 0.003  # maximum distance of a spine from the board's front edge [m]


class Waiting(NamedTuple):
    """State of handing over books, with the number handed over, and the place and time at which the robot
    came to rest.
    """

    given: int = 0
    """Number of books handed over so far."""
    stood: Pose2 = Pose2(0.0, 0.0, 0.0)
    """2D pose world_T_base at which the robot rests, or was last seen moving."""
    since: float = 0.0
    """Simulated time since which the robot rests there and can receive a book, in [s]."""


class BooksThere(Props[BooksSection]):
    """Books of a simulated world by accession number, and shelves by name; the subclass `BookProps` moves
    them.
    """

    section = BooksSection
    STATE: ClassVar[Kinds] = {"books": dict[int, SimulatedBook], "to_come": list[BookSpec], "waits": Waiting}

    def __init__(self, scene: Scene, spec: BooksSection, seed: int) -> None:
        super().__init__(scene, spec, seed)
        self.shelves = {shelf.name: SimulatedShelf(shelf) for shelf in spec.shelves}
        self.books: dict[int, SimulatedBook] = {}
        self.to_come = list(spec.handed_over)
        """Books that a person has not handed over yet."""
        self.waits = Waiting()

    @classmethod
    @override
    def solids(cls, spec: BooksSection) -> Sequence[Solid]:
        return [solid for shelf in spec.shelves for solid in SimulatedShelf(shelf).solids()]

    def set_up(self) -> None:
        """Create the books on the shelves, with spines slightly out of line, and the book on the robot's
        tray.
        """
        for shelf in self.shelves.values():
            rng = keyed(self.seed, f"row of {shelf.name}")
            for spec, y in shelf.standing():
                stands = transform((rng.uniform(-MAX_SPINE_OFFSET_M, MAX_SPINE_OFFSET_M), y, 0.0))
                pose = shelf.pose @ leaned(stands, spec.thickness_mm / 1e3, math.radians(spec.lean_deg))
                self.books[spec.accession] = SimulatedBook(pose, Rest.TABLE, spec, shelf.name)
        if self.spec.tray is not None and self.scene.robot.has_tray:
            self.set_on_tray(self.spec.tray)

    def set_on_tray(self, spec: BookSpec, number: int = 0) -> None:
        """Put a book down on the tray as a person does, with a random error of position and turn.

        Args:
            spec: the book.
            number: how many books a person has handed over, with this one, which selects the random error; 0
                for the book that is on the tray at the start.
        """
        scene, errors = self.scene, self.scene.robot.errors
        dx, dy, turn = keyed(self.seed, f"tray {number}" if number else "tray").standard_normal(3)
        place = errors.book_place_mm / 1e3
        yaw = np.radians(errors.book_turn_deg * turn)
        tray = scene.robot.tray_shape
        spine = (tray.rear + SPINE_ON_TRAY + place * dx, tray.middle[1] + place * dy, tray.top)
        stands = transform(spine, (0.0, 0.0, yaw))
        self.books[spec.accession] = SimulatedBook(
            scene.world_T_base @ stands, Rest.TRAY, spec, base_T_thing=stands
        )
        scene.changes += 1

    @override
    def things(self) -> Iterable[SimulatedBook]:
        return self.books.values()

    def book_pose(self, accession: int) -> Transform:
        """Return world_T_book (4, 4) of the book with an accession number.

        The book's frame: origin at the foot of the spine, in its middle; x from the spine to the fore-edge, y
        to the left as seen facing the spine, z up.
        """
        return self.books[accession].pose

    def shelf_books(self, shelf: str) -> list[StandingBook]:
        """Return the books on a shelf, from left to right."""
        frame = self.shelves[shelf].inverse_pose
        standing = []
        for book in self.books.values():
            if book.rest is Rest.TABLE and book.shelf == shelf:
                pose = frame @ book.pose
                yaw = float(np.arctan2(pose[1, 0], pose[0, 0]))
                lean = -float(np.arctan2(pose[2, 1], pose[2, 2]))
                y, x = float(pose[1, 3]), float(pose[0, 3])
                standing.append(StandingBook(book, y, x, book.tilt(), yaw, lean))
        return sorted(standing, key=lambda item: -item.lateral)

    def tray_book(self) -> SimulatedBook | None:
        """Return the book on the robot's tray; None if the tray holds no book."""
        return next((book for book in self.books.values() if book.rest is Rest.TRAY), None)
