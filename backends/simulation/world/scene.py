"""The true state of a simulated world. Only evaluation and the simulation itself read it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, NamedTuple, TypeVar

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ground_truth import Body, GroundTruth
from handcart.backends.plain_values import Kinds
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.passers.passers import Passers
from handcart.backends.simulation.world.solids import MIN_BODY_HEIGHT_M, FloorPlan, Solid
from handcart.backends.simulation.world.thing import Rest, Thing
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.numerics.arrays import FloatArray

from .scene_props import SceneProps
from .suspension import leaning

GRAVITY_M_S2 = 9.81  # [m/s²]
ScenePropsT = TypeVar("ScenePropsT", bound=SceneProps)


class Contact(NamedTuple):
    """Beginning of a contact: its time, and the names of the part of the robot and of the other body."""

    time: float
    """Simulated time at which the contact began, in [s]."""
    body: str
    """Part of the robot: "base", a link, "load" (the held object), "fingers"."""
    other: str
    """Body that it touched."""


def level(x: float, y: float) -> float:
    """Return 0, the height of a level floor at x and y in the world, all in [m]."""
    return 0.0


@dataclass(eq=False)
class Scene:
    """True state of the simulated world and of the robot in it.

    `base` is the 2D pose world_T_base; `joints` (n,) in [rad] or [m]; `width` the opening between the finger
    pads in [m]; `hand_force` (3,) of the surroundings on the hand in [N] in the hand frame, without noise;
    `contacts` all contacts of the robot so far.
    """

    STATE: ClassVar[Kinds] = {
        "base": Pose2,
        "tilted_base": Transform | None,
        "joints": FloatArray,
        "width": float,
        "time": float,
        "held_name": str | None,
        "hand_T_held": Transform,
        "lean": tuple[float, float],
        "hand_force": FloatArray,
        "contacts": list[Contact],
        "touching": frozenset[tuple[str, str]],
        "changes": int,
    }
    """Attributes that a checkpoint keeps, with their types."""

    robot: RobotFile
    arm: ArmModel | None
    solids: tuple[Solid, ...]
    """All solids of the world: the room's, then those of domains."""
    base: Pose2
    joints: FloatArray
    width: float
    plain_solids: tuple[Solid, ...] = ()
    """Solids that the camera sees as plain boxes."""
    props: dict[str, SceneProps] = field(default_factory=dict)
    """Domains' objects, by the domain's name."""
    passers: Passers = field(default_factory=Passers)
    """People and carts that walk about."""
    time: float = 0.0
    lean: tuple[float, float] = (0.0, 0.0)
    """Roll and pitch of the base on its suspension, in [rad], positive as in a URDF (right side down, front
    down).
    """
    held: Thing | None = None
    hand_T_held: Transform = field(default_factory=lambda: np.eye(4))
    hand_force: FloatArray = field(default_factory=lambda: np.zeros(3))
    contacts: list[Contact] = field(default_factory=list)
    touching: frozenset[tuple[str, str]] = frozenset()
    """Touching pairs of this period, as in `Contact`."""
    open_ground: bool = False
    """True outdoors: released things rest on the ground."""
    ground_height: Callable[[float, float], float] = level
    """Function that returns the height of the ground at x and y in the world, all in [m]."""
    tilted_base: Transform | None = None
    """world_T_base (4, 4) if physics lets the base tilt; None: it is level."""
    start: Pose2 = field(default_factory=lambda: Pose2(0.0, 0.0, 0.0))
    """world_T_base where the robot was put at first."""
    changes: int = 0
    """Number of times that a thing was moved; caches of values derived from poses compare it."""
    _leant: tuple[tuple[Pose2, tuple[float, float]], Transform] | None = field(default=None, repr=False)
    """Cache of the last base and lean, with their world_T_base (4, 4), needed many times in a period."""
    _owners: dict[int, tuple[Thing, SceneProps]] = field(default_factory=dict, repr=False)
    """Cache of `props_of`, each thing by its `id` with its props."""

    @cached_property
    def body_plan(self) -> FloorPlan:
        """Floor plan of the world's solids at the heights of the base's body, which the base may run into."""
        return FloorPlan(self.solids, MIN_BODY_HEIGHT_M, self.robot.body_height)

    @cached_property
    def full_plan(self) -> FloorPlan:
        """Floor plan of the world's solids below 2 m of height, which any part of the robot may run into."""
        return FloorPlan(self.solids, MIN_BODY_HEIGHT_M, 2.0)

    def world_T_map(self, own_start: Pose2 | None) -> Pose2:
        """Return world_T_map, the 2D pose of a robot's map in the world.

        Args:
            own_start: map_T_base that the robot gives its start because it has no map; None with a map, which
                has the world's frame.
        """
        return Pose2(0.0, 0.0, 0.0) if own_start is None else self.start.compose(own_start.inverse())

    @property
    def held_name(self) -> str | None:
        """Name of the object that the robot's hand holds; None if the hand is empty."""
        return None if self.held is None else self.held.name

    @held_name.setter
    def held_name(self, name: str | None) -> None:
        self.held = self.thing_named(name)

    def thing_named(self, name: str | None) -> Thing | None:
        """Return a thing by its name; None if `name` is None.

        Raises:
            NotAState: no thing has that name.
        """
        found = next((thing for thing in self.things() if thing.name == name), None)
        if name is not None and found is None:
            raise NotAState(f"no saved state: this world lacks {name!r}")
        return found

    # Positions of things

    @property
    def world_T_base(self) -> Transform:
        """True pose world_T_base (4, 4) of the base, with its tilt."""
        return self.leaning_at(self.base) if self.tilted_base is None else self.tilted_base

    def leaning_at(self, base: Pose2) -> Transform:
        """Return world_T_base (4, 4) if the base were at another 2D pose with its present tilt.

        Args:
            base: 2D pose world_T_base; the tilt is that of the base on its suspension.
        """
        if self._leant is None or self._leant[0] != (base, self.lean):
            pose = base.lift()
            if self.lean != (0.0, 0.0):
                pose = pose @ leaning(self.lean, self.robot.errors.lean_pivot_m)
            self._leant = (base, self.lean), pose
        return self._leant[1].copy()

    def world_T(self, frame: str) -> Transform:
        """Return the true pose (4, 4) of a frame of the robot in the world."""
        if self.arm is None:
            return self.world_T_base @ base_T_frame(self.robot.urdf_text(), frame)
        return self.world_T_base @ self.arm.forward(self.joints, frame)

    def of(self, kind: type[ScenePropsT]) -> ScenePropsT:
        """Return the collection of one domain's things, which is empty if the world's file has none of them.

        Args:
            kind: class of the domain's things.
        """
        found = next((prop for prop in self.props.values() if isinstance(prop, kind)), None)
        return kind.none_in(self) if found is None else found

    def things(self) -> list[Thing]:
        """Return all things in the world that hands can carry."""
        return [thing for props in self.props.values() for thing in props.things()]

    def props_of(self, thing: Thing) -> SceneProps:
        """Return the collection, of one application domain, that a thing belongs to."""
        known = self._owners.get(id(thing))
        if known is None or known[0] is not thing:
            owner = next(
                props for props in self.props.values() if any(item is thing for item in props.things())
            )
            known = self._owners[id(thing)] = thing, owner
        return known[1]

    def riding(self) -> list[Thing]:
        """Return the things that the robot carries on its own table or tray, not in its hand."""
        tray = Rest.TRAY  # looked up in an enumeration slowly, and there may be many things
        return [thing for props in self.props.values() for thing in props.things() if thing.rest is tray]

    def felt_force(self) -> FloatArray:
        """Return the force (3,) that the hand's sensor feels, in the hand frame, in [N], without noise.

        It is the sum of contact forces, the weight of a held object that the sensor feels, and forces that
        application domains add.
        """
        force = self.hand_force
        for props in self.props.values():
            force = force + props.hand_force()
        if self.held is not None and self.held.WEIGHS:
            down = np.array([0.0, 0.0, -GRAVITY_M_S2 * self.held.mass])
            force = force + self.world_T("hand")[:3, :3].T @ down
        return force

    def truth(self) -> GroundTruth:
        """Return a copy of the true state of the robot and all bodies."""
        bodies = {thing.name: self._body(thing) for thing in self.things()}
        slides = np.array(self.robot.joint_units.slides[: self.joints.size], dtype=np.bool_)
        bumps = sum(contact.body == "base" for contact in self.contacts)
        return GroundTruth(self.base, self.joints.copy(), slides, float(self.width), bodies, bumps)

    def _body(self, thing: Thing) -> Body:
        if self.held is thing:
            return Body("hand", inverse(self.world_T("hand")) @ thing.pose)
        if thing.rest is Rest.TRAY:
            return Body("tray", inverse(self.world_T_base) @ thing.pose)
        return Body(thing.carrier, thing.pose.copy())

    # Changes of the scene

    def move_base(self, base: Pose2) -> None:
        """Put the base and all that it carries at another 2D pose world_T_base; the held object moves with
        the hand.
        """
        self.base = base
        self._carry_along()

    def lean_to(self, lean: tuple[float, float]) -> None:
        """Set the base's roll and pitch on its suspension, in [rad]; what lies on the base tilts with it."""
        if lean != self.lean:
            self.lean = lean
            self._carry_along()

    def _carry_along(self) -> None:
        if not (riding := self.riding()):
            return
        world_T_base = self.world_T_base
        for thing in riding:
            thing.pose = world_T_base @ thing.base_T_thing
            self.changes += 1

    def touch(self, pairs: frozenset[tuple[str, str]]) -> None:
        """Record the pairs of bodies that touch in this period; each new pair is a new contact."""
        for body, other in sorted(pairs - self.touching):
            self.contacts.append(Contact(self.time, body, other))
        self.touching = pairs
