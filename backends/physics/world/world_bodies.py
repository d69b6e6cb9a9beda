"""Surroundings of the robot, as bodies."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import ClassVar

import numpy as np

from handcart.backends.physics.engine.engine import Engine
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.bodies import Bodies
from handcart.backends.simulation.passers.passers import PASSER_GREY, PasserPart
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.solids import THE_GROUND, Solid
from handcart.backends.simulation.world.thing import Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.shapes import Box

from .terrain import Terrain
from .thing_body import ThingBody

FLOOR_NAME = "floor"
MAX_TILE_INDEX = 10_000  # tile of the ground
MAX_LATE_BODIES = 1000  # tiles and things that come after the beginning
FLOOR_FRICTION = 1.0
SOLID_FRICTION = 0.65
PASSER_TURNS_RAD = (0.0, math.pi / 4)  # turns of the boxes that approximate a disc
_AWAY = transform((0.0, 0.0, -50.0))
_WALL, _FURNITURE, _WOOD = 165, 110, 130


class WorldBodies:
    """All bodies of a world in a physics engine (floor or ground, solids, printed sheets and things).

    Solids do not move, but some appear or disappear during a run; things are rigid bodies that rest, lean and
    fall.
    """

    STATE: ClassVar = {"made": list[tuple[int, int] | str]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, engine: Engine, scene: Scene, terrain: Terrain | None = None) -> None:
        """Build the bodies of the scene.

        Args:
            engine: engine with an empty world.
            scene: true state of the world.
            terrain: rough ground in place of a level floor; None: a level floor.
        """
        self._engine, self._scene, self._terrain = engine, scene, terrain
        self.names: dict[int, str] = {}
        if terrain is None:
            self.names[engine.add_floor(FLOOR_FRICTION)] = FLOOR_NAME
        self._made: list[tuple[int, int] | str] = []
        self._weighed: list[ThingBody] = []
        """Bodies of things whose mass may change, because it doesn't follow from their size alone."""
        self._surprises: list[tuple[int, Solid]] = []
        self._passers: list[int] = []
        """Bodies of passers' parts, two for each, in the order of `Passers.parts`."""
        for solid in scene.solids:
            if solid is THE_GROUND and terrain is not None:
                continue
            passes = solid.appears > 0.0 or bool(np.isfinite(solid.leaves))
            look = _grey(solid), passes, solid.material
            body = engine.add_box(solid.box, SOLID_FRICTION, *look)
            self.names[body] = solid.box.name
            if passes:
                self._surprises.append((body, solid))
        for part in scene.passers.parts():
            self._passers += self._add_passer(part)
        for sheet in (sheet for props in scene.props.values() for sheet in props.sheets()):
            engine.add_sheet(sheet)
        self.kinds = Bodies()
        self.things: dict[str, ThingBody] = {}
        """Bodies of things, by their names."""
        self.bodies: dict[str, int] = {}
        """Engine's numbers of all things' bodies."""
        self.fixed: set[int] = set()
        """Engine's numbers of the bodies that move with a joint of the world alone."""
        for thing in scene.things():
            self.add(thing)
        self._made.clear()
        self.keep_time()

    def add(self, thing: Thing) -> None:
        """Add a body for a thing, at the thing's pose."""
        kind: type[ThingBody] = self.kinds.of(thing, ThingBody)
        made = self.things[thing.name] = kind(self._engine, thing)
        self.bodies[thing.name] = made.id
        self.names[made.id] = thing.name
        self._made.append(thing.name)
        if not thing.FREE:
            self.fixed.add(made.id)
        if type(thing).mass is not Thing.mass:
            self._weighed.append(made)

    def keep_things(self) -> None:
        """Add bodies for movable things that are new in the scene, and update the masses of all things'
        bodies.

        Called at the beginning of a control period.
        """
        for thing in self._scene.things():
            if thing.name not in self.things:
                self.add(thing)
        for body in self._weighed:
            body.keep()

    def reach(self, x: float, y: float) -> None:
        """Create the missing tiles of rough ground around a position x, y in the world, in [m]."""
        for tile in self._terrain.reach(x, y) if self._terrain is not None else ():
            self._add_tile(tile)

    @property
    def made(self) -> list[tuple[int, int] | str]:
        """Bodies created after the start, in the order of creation.

        An item is the (column, row) of a tile of ground, or the name of a thing. Setting this property to a
        list from a checkpoint creates the bodies of the list that are missing in this engine; their things
        must be in the scene.
        """
        return list(self._made)

    @made.setter
    def made(self, wanted: Sequence[tuple[int, int] | str]) -> None:
        """Create those bodies that a saved run added after its start and that are missing here, in the saved
        order.

        Args:
            wanted: all added bodies of the saved run, in order: a tile of rough ground by its indices, a
                thing by its name.

        Raises:
            NotAState: the existing bodies are not the first bodies of the saved run, or a body cannot be
                created.
        """
        begun = list(wanted[: len(self._made)]) == self._made
        if not begun or len(set(wanted)) != len(wanted) or len(wanted) > MAX_LATE_BODIES:
            raise NotAState("no saved state: its world was made in another order")
        for item in wanted[len(self._made) :]:
            if isinstance(item, str):
                self._add_named(item)
            else:
                self._add_tile(item)

    def _add_named(self, name: str) -> None:
        thing = self._scene.thing_named(name)
        assert thing is not None
        if name in self.bodies:
            raise NotAState(f"no saved state: {name} was made twice")
        self.add(thing)

    def _add_tile(self, tile: tuple[int, int]) -> None:
        if self._terrain is None or max(map(abs, tile)) > MAX_TILE_INDEX:
            raise NotAState(f"no saved state: the ground is missing at the tile {tile}")
        self.names[self._terrain.add(tile)] = FLOOR_NAME
        self._made.append(tile)

    def moved(self) -> Collection[int] | None:
        """Return the engine's numbers of the bodies that may have moved since the last call; None if that is
        unknown.
        """
        return self._engine.moved()

    def pose(self, thing: Thing) -> Transform:
        """Return the true pose world_T_thing (4, 4) of a thing."""
        return self._engine.pose(self.bodies[thing.name]) @ inverse(thing.thing_T_middle)

    def keep_time(self) -> None:
        """Move the solids that appear or disappear during a run, and the people and carts that pass by, to
        where they are at the scene's present time.
        """
        for body, solid in self._surprises:
            there = solid.appears <= self._scene.time < solid.leaves
            self._engine.set_pose(body, solid.box.pose if there else _AWAY)
        parts = [part for part in self._scene.passers.parts() for _ in PASSER_TURNS_RAD]
        for index, (body, part) in enumerate(zip(self._passers, parts, strict=True)):
            self._engine.set_pose(body, _upright(part, PASSER_TURNS_RAD[index % len(PASSER_TURNS_RAD)]))

    def _add_passer(self, part: PasserPart) -> list[int]:
        """Add a disc as two boxes, one turned by 45 degrees: engines and their beams know boxes best."""
        side = math.sqrt(2.0) * part.radius
        found = []
        for turn in PASSER_TURNS_RAD:
            box = Box(_upright(part, turn), (side, side, part.high - part.low), part.name)
            found.append(self._engine.add_box(box, SOLID_FRICTION, PASSER_GREY, True))
            self.names[found[-1]] = part.name
        return found


def _upright(part: PasserPart, turn: float) -> Transform:
    """Return the pose (4, 4) in the world of the middle of a passer's part, turned about z by an angle in
    [rad].
    """
    return Pose2(part.x, part.y, turn).lift((part.low + part.high) / 2)


def _grey(solid: Solid) -> int:
    if solid.grey is not None:
        return solid.grey
    if solid.box.name.startswith("wall"):
        return _WALL
    return _WOOD if " of " in solid.box.name else _FURNITURE
