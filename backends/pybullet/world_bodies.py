"""What stands around the robot, as Bullet's bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from handcart.backends.saved_state import NotAState
from handcart.backends.scene.block import Block
from handcart.backends.scene.book import Book
from handcart.backends.scene.scene import Scene
from handcart.backends.scene.solids import THE_GROUND, Solid
from handcart.backends.scene.thing import Thing
from handcart.robotics.geometry.transform import Transform, inverse, transform

from .painted import add_mark, painted_block
from .physics import Physics, placed
from .printed_book import PrintedBook
from .rounded_book import rounded_book
from .terrain import Terrain

FLOOR = "floor"
FARTHEST = 10_000  # tile of the ground
MOST = 1000  # tiles and things that come after the beginning
FLOOR_FRICTION = 1.0
SOLID_FRICTION = 0.65
THING_FRICTION = 0.65  # squared, 0.42: paper on paper, paper on wood, wood on wood
PAPER = 700.0  # of a book [kg/m³]
WOOD = 600.0  # of a block [kg/m³]
BLOCK_STIFFNESS, BLOCK_DAMPING = 1e6, 1e4
"""Of each point at which a block touches something, in [N/m] and [Ns/m]."""
_AWAY = transform((0.0, 0.0, -50.0))
_FROM_AFAR = 110  # grey of a book
_WALL, _FURNITURE, _WOOD, _DARK = 165, 110, 130, 16


class WorldBodies:
    """Floor, solids, marks, books and blocks.

    Surprises come and go; books and blocks are rigid bodies that stand, lean and fall.
    """

    STATE: ClassVar = {"made": list[tuple[int, int] | str]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, physics: Physics, scene: Scene, terrain: Terrain | None = None) -> None:
        """Build them as the scene has them; `terrain` is there instead of a level floor."""
        self._physics, self._scene, self._terrain = physics, scene, terrain
        self.names: dict[int, str] = {}
        if terrain is None:
            self.names[physics.add_floor(FLOOR_FRICTION)] = FLOOR
        self._made: list[tuple[int, int] | str] = []
        self._surprises: list[tuple[int, Solid]] = []
        for solid in scene.solids:
            if solid is THE_GROUND and terrain is not None:
                continue
            body = physics.add_box(solid.box, SOLID_FRICTION, _grey(solid.box.name))
            self.names[body] = solid.box.name
            if solid.appears > 0.0 or np.isfinite(solid.leaves):
                self._surprises.append((body, solid))
        for mark in scene.marks:
            add_mark(physics, mark)
        self._plain = physics.load_texture(np.full((4, 4), _FROM_AFAR, np.uint8))
        self.bodies: dict[str, int] = {}
        """Body of each book and block, by its name."""
        self.printed: dict[str, PrintedBook] = {}
        """The books' looks, by name."""
        for thing in scene.things():
            self.add(thing)
        self._made.clear()
        self.keep_time()

    def add(self, thing: Thing) -> None:
        """A book or block as a body where it is; asleep until something touches it."""
        p, client = self._physics.p, self._physics.client
        if isinstance(thing, Book):
            body = self._add_book(thing)
        else:
            assert isinstance(thing, Block)
            body = self._add_block(thing)
        state = p.ACTIVATION_STATE_ENABLE_SLEEPING
        if isinstance(thing, Book) and thing.shelf is not None:
            state |= p.ACTIVATION_STATE_SLEEP
        p.changeDynamics(
            body, -1, lateralFriction=THING_FRICTION, activationState=state, physicsClientId=client
        )
        self.bodies[thing.name] = body
        self.names[body] = thing.name
        self._made.append(thing.name)

    def reach(self, x: float, y: float) -> None:
        """See that there is ground about a place, in [m]."""
        for tile in self._terrain.reach(x, y) if self._terrain is not None else ():
            self._add_tile(tile)

    @property
    def made(self) -> list[tuple[int, int] | str]:
        """What came after the beginning, in this order: tiles of the terrain, and things by name."""
        return list(self._made)

    @made.setter
    def made(self, wanted: Sequence[tuple[int, int] | str]) -> None:
        """Make what is missing of what another run had made, in its order; the scene has the things."""
        begun = list(wanted[: len(self._made)]) == self._made
        if not begun or len(set(wanted)) != len(wanted) or len(wanted) > MOST:
            raise NotAState("no saved state: its world was made in another order")
        for each in wanted[len(self._made) :]:
            if isinstance(each, str):
                self._add_named(each)
            else:
                self._add_tile(each)

    def _add_named(self, name: str) -> None:
        thing = self._scene.thing_named(name)
        assert thing is not None
        if name in self.bodies:
            raise NotAState(f"no saved state: {name} was made twice")
        self.add(thing)

    def _add_tile(self, tile: tuple[int, int]) -> None:
        if self._terrain is None or max(map(abs, tile)) > FARTHEST:
            raise NotAState(f"no saved state: there is no ground at the tile {tile}")
        self.names[self._terrain.add(tile)] = FLOOR
        self._made.append(tile)

    def _add_book(self, book: Book) -> int:
        """One that stands in a row as a box, one to be returned with rounded edges."""
        shape = self._box(book) if book.shelf is not None else rounded_book(self._physics, book.size)
        printed = PrintedBook(self._physics, book, self._plain)
        body = self._make(book, shape, printed.visual)
        printed.show(body, printed=False)
        self.printed[book.name] = printed
        return body

    def _add_block(self, block: Block) -> int:
        visual, texture = painted_block(self._physics, block)
        body = self._make(block, self._box(block), visual)
        p, client = self._physics.p, self._physics.client
        p.changeVisualShape(body, -1, textureUniqueId=texture, physicsClientId=client)
        # Else a block that is pressed between two others creeps away, however little pushes it.
        p.changeDynamics(
            body,
            -1,
            frictionAnchor=1,
            contactStiffness=BLOCK_STIFFNESS,
            contactDamping=BLOCK_DAMPING,
            physicsClientId=client,
        )
        return body

    def _box(self, thing: Thing) -> int:
        p, half = self._physics.p, [size / 2 for size in thing.size]
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=self._physics.client)
        return int(shape)

    def _make(self, thing: Thing, shape: int, visual: int) -> int:
        pose = thing.pose @ thing.thing_T_middle
        p, client = self._physics.p, self._physics.client
        return int(p.createMultiBody(self.mass(thing), shape, visual, *placed(pose), physicsClientId=client))

    def mass(self, thing: Thing) -> float:
        """In [kg]."""
        density = PAPER if isinstance(thing, Book) else WOOD
        return float(density * np.prod(thing.size))

    def pose(self, thing: Thing) -> Transform:
        """world_T_thing (4, 4), as it truly is."""
        return self._physics.pose(self.bodies[thing.name]) @ inverse(thing.thing_T_middle)

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
