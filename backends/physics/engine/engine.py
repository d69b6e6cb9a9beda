"""Interface of a physics engine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handcart.backends.simulation.world.material import WOOD_MATERIAL, Material
from handcart.backends.simulation.world.sheet import Sheet
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .thing_form import ThingForm

MAX_SOLVER_STEP_S = 0.0025  # of the solver, at most [s]
GRAVITY_M_S2 = 9.81  # [m/s²]

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Pinned:
    """Rigid connection of two bodies by points at which they are fixed to each other.

    The points are given (n, 3) in [m], in a frame at the centre of mass of each body.
    """

    body: int
    link: int
    """Link of `body`."""
    other: int
    points: tuple[Point, ...]
    other_points: tuple[Point, ...]
    force_n: float
    """Largest force that holds each point."""


class Touching(NamedTuple):
    """Contact between a link of the body that a caller asked about and a link of another body.

    `link` is a number in the first body, `other_link` in the other one, which has the number `other`.
    """

    link: int
    other: int
    other_link: int


class ContactPoint(NamedTuple):
    """Point at which another body presses against a body, with the normal towards that body and the force on
    it.
    """

    link: int
    """Link of the body."""
    other: int
    other_link: int
    normal: Point
    """Unit normal from the other body towards this one, in the world frame."""
    force: Point
    """Force of the other body on this one, in the world frame, in [N]."""


class Engine(ABC):
    """Interface of a physics engine, which computes the motion of a world's numbered bodies in steps.

    One of the bodies is the robot, with several links; the others are things, boxes and ground.
    """

    CHUNK: ClassVar[float]
    """Time between two actions of the drives (a chunk), in [s], if it is less than a control period; infinity
    for an engine whose own drives follow set-points in each of its steps.
    """
    CONTACTS_CARRY: ClassVar[float]
    """Share of the friction of the fingers' pads, 0 to 1, that contacts have.

    If a held thing would creep although contacts carry it, the points of `Grip` have the remaining share.
    """

    def __init__(self, period: float) -> None:
        """Create a world with a control period of that length, in [s]."""
        self.chunks = max(1, round(period / self.CHUNK))
        """Number of times that the drives act in a control period."""
        self.chunk = period / self.chunks
        """Time between two actions of the drives (a chunk), in [s]."""
        self.substeps = max(1, int(np.ceil(self.chunk / MAX_SOLVER_STEP_S - 1e-9)))
        """Steps of the solver in a chunk."""

    @property
    @abstractmethod
    def pinned(self) -> Pinned | None:
        """Rigid connection that fixes one body to another, such as a held thing to the hand; None if no
        bodies are connected.
        """

    def parts(self) -> Sequence[int]:
        """Return the numbers of solver steps to make before each reading of the contacts, in order.

        Their sum is the number of steps in a chunk, the time between two commands to the drives.
        """
        return (self.substeps,)

    @abstractmethod
    def step(self, steps: int | None = None) -> None:
        """Advance the simulation.

        Args:
            steps: number of solver steps, one of the numbers in `parts`; None: all steps of a chunk, which is
                the time between two commands to the drives.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the engine; a second call does nothing."""

    # Bodies

    @abstractmethod
    def add_floor(self, friction: float) -> int:
        """Add a level floor at height 0 with Coulomb's coefficient of friction, without unit.

        Returns:
            The floor's number as a body of the engine.
        """

    @abstractmethod
    def add_box(
        self, box: Box, friction: float, grey: int, moves: bool = False, material: Material = WOOD_MATERIAL
    ) -> int:
        """Add a box that forces do not move; return its number as a body of the engine.

        Args:
            box: pose in the world and size, in [m].
            friction: Coulomb's coefficient of friction, without unit.
            grey: grey of its sides in the robot's cameras, 0 to 255.
            moves: True for a box that the program may move by `set_pose`.
            material: appearance in pictures for people.
        """

    @abstractmethod
    def add_tile(self, corner: FloatArray, cell: float, heights: FloatArray, friction: float) -> int:
        """Add a square of rough ground; return its number as a body of the engine.

        Args:
            corner: (2,) corner of the square with the least x and y in the world, in [m].
            cell: distance of neighbouring heights along x and y, in [m].
            heights: (n, n) heights of the ground in [m], a row for each y and a column for each x, both
                ascending.
            friction: Coulomb's coefficient of friction, without unit.
        """

    @abstractmethod
    def add_sheet(self, sheet: Sheet) -> None:
        """Add a printed sheet that is visible but cannot be touched."""

    @abstractmethod
    def add_thing(self, form: ThingForm) -> int:
        """Add a rigid body with the pose, mass and shapes of `form`, which moves freely or on a joint fixed
        to the world. Return the number of the body in this engine.
        """

    @abstractmethod
    def show(self, body: int, picture: ByteArray) -> None:
        """Replace the texture of all faces of a thing by one grey picture (h, w), 0 to 255."""

    @abstractmethod
    def weigh(self, body: int, mass: float) -> None:
        """Set the mass of a thing, in [kg]."""

    @abstractmethod
    def pose(self, body: int) -> Transform:
        """Return the pose world_T_body (4, 4) of a body's centre of mass."""

    def moved(self) -> Collection[int] | None:
        """Return the engine's numbers of the bodies that may have moved since the last call. None means that
        this is unknown, so that any body may have moved.
        """
        return None

    @abstractmethod
    def set_pose(self, body: int, pose: Transform) -> None:
        """Put a body to rest at a pose world_T_body (4, 4) of its centre of mass."""

    @abstractmethod
    def pull(self, body: int | None, force: FloatArray) -> None:
        """Apply a constant force at the centre of mass of one thing, until the next call.

        Args:
            body: number of the thing; None: the present force ends, and no new one is applied.
            force: (3,) in the world frame, in [N].
        """

    @abstractmethod
    def touches(self, body: int, anything: bool) -> None:
        """Switch the collisions of a thing with all other bodies on (`anything` is True) or off."""

    @abstractmethod
    def pin(self, wanted: Pinned | None) -> None:
        """Replace the current rigid connection of two bodies by `wanted`; None: release it without a
        new one.
        """

    def pin_force(self) -> FloatArray:
        """Return the force (3,) that the present rigid connection of two bodies (`pinned`) exerts on the
        first of them, in the world frame, in [N].
        """
        return np.zeros(3)

    # Bodies of the world

    @abstractmethod
    def touching(self, body: int) -> Collection[Touching]:
        """Return the pairs of touching links of a body and other bodies, or of the robot and itself.

        It returns the same pairs as `contacts`, without points and forces, but faster.
        """

    @abstractmethod
    def contacts(self, body: int) -> Sequence[ContactPoint]:
        """Return the contact points of a body with other bodies; if it is the robot, also of its links with
        each other.
        """

    @abstractmethod
    def free_shares(self, start: FloatArray, ends: FloatArray) -> FloatArray:
        """Return the fraction of each line from a start to an end that is free of bodies other than the
        robot's.

        Args:
            start: (3,) common start of the lines in the world, in [m].
            ends: (n, 3) ends of the lines in the world, in [m].

        Returns:
            (n,) distance from the start to the first body divided by the line's length, 0 to 1; infinity if
            all of a line is free.
        """

    # States

    @abstractmethod
    def state(self) -> dict[str, Any]:
        """Return positions, velocities and rigid connections of all bodies, as plain data."""

    @abstractmethod
    def set_state(self, state: object) -> None:
        """Restore a state that was returned by `state` of this engine, or of another engine whose bodies were
        created in the same order.
        """
