"""The books and shelves of a simulated world."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from typing_extensions import override

from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.backends.simulation.world.grasp import MIN_BITE_M, PAD_LENGTH_M, Pads
from handcart.backends.simulation.world.painting import Painted
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .book import SimulatedBook
from .book_rest import book_rest
from .books_there import BooksThere
from .person import Person
from .putting_down import put_down
from .row_rule import RowRule
from .spec import BooksSection

AWAKE_DISTANCE_M = 1.3  # books of shelves further from the hand than this sleep in physics [m]


class BookProps(BooksThere):
    """Books and shelves of a simulated world, with rules for gripping, inserting and releasing books.

    A person hands books over. Without a physics engine, books differ from real ones:

    - Whether a book enters its slot is decided once for each entry, by a rule fitted to a physics engine
      (`insertion.entry_chance`); in the slot the book aligns with the slot. Books that are pushed slide
      straight back against 3 N (10 N if an edge jams), and nothing stops them before the shelf's back.
    - A book released at most 20 mm above a tray rests there upright. Above a board it is left leaning aside a
      little (`errors.book_lean_deg`, and the hand's own tilt). If its centre of mass is beyond its lower
      edge, it tips over; its neighbours stop it and do not move (`book_lean`). In all other cases it falls
      flat onto the floor or the board, and is lost.

    In a physics engine, books in a row have square edges, and books to be returned have rounded leading edges
    (3 mm). Things inside a shelf are painted dark.
    """

    PAINTS_SOLIDS = True

    def __init__(self, scene: Scene, spec: BooksSection, seed: int) -> None:
        super().__init__(scene, spec, seed)
        self._rule: RowRule | None = None
        self._person: Person | None = None
        self._places = np.array([shelf.pose[:3, 3] for shelf in self.shelves.values()]).reshape(-1, 3)
        """Positions (n, 3) of the shelves' frames in the world, in [m]."""

    @override
    def set_up(self) -> None:
        super().set_up()
        self._person = Person(self)

    @override
    def painted(self, rests: frozenset[Rest]) -> Iterable[Painted]:
        from .painted_books import painted  # fonts and all: not before a camera looks

        return painted(self, rests)

    # What happens

    @override
    def taken(self, thing: Thing) -> None:
        assert isinstance(thing, SimulatedBook)
        thing.rest, thing.shelf = Rest.HAND, None

    @override
    def step(self) -> None:
        if self._person is not None:
            self._person.step()

    @override
    def hand_rule(self, arm: ArmModel) -> RowRule:
        self._rule = RowRule(self, arm)
        return self._rule

    @override
    def thickness(self, thing: Thing, pads: Pads) -> float:
        return thing.size[1]

    def fits(self, thing: Thing, pads: Pads) -> bool:
        """Return True if the closing pads of the fingers would grip a book at its covers, from in front of
        its spine.

        Args:
            thing: the book.
            pads: pose and shape of the fingers' pads.
        """
        finger = pads.finger
        pose = inverse(pads.world_T_hand) @ thing.pose
        depth, thick, height = thing.size
        x, y, z = pose[:3, 3]
        inside = x < finger.tip - MIN_BITE_M and x + depth > finger.tip - PAD_LENGTH_M and pose[0, 0] > 0.9
        level = z < finger.height / 2 and z + height > -finger.height / 2
        return bool(inside and level and abs(y) + thick / 2 < pads.outer())

    def gripped(self, thing: Thing, pads: Pads) -> Transform:
        """Return the pose hand_T_thing (4, 4) that a book takes when the pads close on it.

        The book is centred between the pads and aligned with the hand; its x and z in the hand frame do not
        change.
        """
        before = inverse(pads.world_T_hand) @ thing.pose
        pitch = float(np.arctan2(-before[2, 0], before[0, 0]))
        return transform((before[0, 3], 0.0, before[2, 3]), (0.0, pitch, 0.0))

    @override
    def let_go(self, thing: Thing) -> None:
        assert isinstance(thing, SimulatedBook)
        slot = None if self._rule is None else self._rule.left()
        put_down(self, thing, slot, self._left_aside(thing))

    def _left_aside(self, book: SimulatedBook) -> float:
        """Return the left tilt of a book as the second finger leaves it, in [rad]."""
        spread = math.radians(self.scene.robot.errors.book_lean_deg)
        instant = round(self.scene.time / self.scene.robot.period_s)
        return spread * float(keyed(self.seed, f"{book.name} let go", instant).standard_normal())

    # Props in a physics engine

    @override
    def awake(self, hand: FloatArray) -> Iterable[SimulatedBook]:
        away = np.linalg.norm(self._places - hand, axis=1)
        near = {name for name, far in zip(self.shelves, away.tolist(), strict=True) if far < AWAKE_DISTANCE_M}
        return [book for book in self.books.values() if book.rest is not Rest.TABLE or book.shelf in near]

    @override
    def rested(self, thing: Thing) -> None:
        assert isinstance(thing, SimulatedBook)
        thing.rest, thing.shelf = book_rest(self, thing)
        if thing.rest is Rest.TRAY:
            thing.base_T_thing = inverse(self.scene.world_T_base) @ thing.pose
