"""What stands around the robot, as Bullet's bodies."""

from __future__ import annotations

import numpy as np

from backends.scene.book import Book
from backends.scene.scene import Scene
from backends.scene.solids import Solid
from robotics.geometry.transform import Transform, inverse, transform

from .physics import Physics, placed
from .printed_book import PrintedBook
from .rounded_book import rounded_book

FLOOR_FRICTION = 1.0
SOLID_FRICTION = 0.65
BOOK_FRICTION = 0.65  # squared, 0.42: paper on paper, paper on wood
PAPER = 700.0  # of a book [kg/m³]
_AWAY = transform((0.0, 0.0, -50.0))
_FROM_AFAR = 110  # grey of a book
_WALL, _FURNITURE, _WOOD, _DARK = 165, 110, 130, 16


class WorldBodies:
    """Floor, solids and books. Surprises come and go; books are rigid bodies that stand, lean and fall."""

    def __init__(self, physics: Physics, scene: Scene) -> None:
        """Build them as the scene has them."""
        self._physics, self._scene = physics, scene
        self.names: dict[int, str] = {physics.add_floor(FLOOR_FRICTION): "floor"}
        self._surprises: list[tuple[int, Solid]] = []
        for solid in scene.solids:
            body = physics.add_box(solid.box, SOLID_FRICTION, _grey(solid.box.name))
            self.names[body] = solid.box.name
            if solid.appears > 0.0 or np.isfinite(solid.leaves):
                self._surprises.append((body, solid))
        self._plain = physics.load_texture(np.full((4, 4), _FROM_AFAR, np.uint8))
        self.books: dict[int, int] = {}
        """Body of each book, by its accession."""
        self.printed: dict[int, PrintedBook] = {}
        for book in scene.books.values():
            self.add_book(book)
        self.keep_time()

    def add_book(self, book: Book) -> None:
        """A book as a body where it is: one that stands in a row as a box, one to be returned with rounded
        edges. Asleep until something touches it."""
        p, client = self._physics.p, self._physics.client
        if book.shelf is not None:
            half = [size / 2 for size in book.size]
            shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
        else:
            shape = rounded_book(self._physics, book.size)
        printed = PrintedBook(self._physics, book, self._plain)
        pose = book.pose @ book.thing_T_middle
        mass = float(PAPER * np.prod(book.size))
        body = int(p.createMultiBody(mass, shape, printed.visual, *placed(pose), physicsClientId=client))
        state = p.ACTIVATION_STATE_ENABLE_SLEEPING
        if book.shelf is not None:
            state |= p.ACTIVATION_STATE_SLEEP
        p.changeDynamics(
            body, -1, lateralFriction=BOOK_FRICTION, activationState=state, physicsClientId=client
        )
        self.books[book.accession] = body
        printed.show(body, printed=False)
        self.printed[book.accession] = printed
        self.names[body] = f"book {book.accession}"

    def mass(self, book: Book) -> float:
        """In [kg]."""
        return float(PAPER * np.prod(book.size))

    def book_pose(self, book: Book) -> Transform:
        """world_T_book (4, 4), as it truly is."""
        return self._physics.pose(self.books[book.accession]) @ inverse(book.thing_T_middle)

    def keep_time(self) -> None:
        """Put surprises where they are at the scene's time."""
        for body, solid in self._surprises:
            there = solid.appears <= self._scene.time < solid.leaves
            self._physics.set_pose(body, solid.box.pose if there else _AWAY)


def _grey(name: str) -> int:
    if name.startswith("wall"):
        return _WALL
    inside = ("back of", "board of", "left panel of", "right panel of")
    if name.startswith(inside):
        return _DARK
    return _WOOD if " of " in name else _FURNITURE
