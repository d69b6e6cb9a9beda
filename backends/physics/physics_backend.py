"""A robot in a physics engine, with a real robot's errors."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Set
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.backend import RobotFault
from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.engine.engine import Engine
from handcart.backends.physics.engine.surface import CASTER_SURFACE
from handcart.backends.plain_values import Kinds
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.simulated_backend import ChangingPart, SimulatedBackend
from handcart.backends.simulation.world.thing import Thing
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.urdf.robot_shape import finger_shape
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse

from .body.grip import Grip, pads_in
from .body.physics_arm import PhysicsArm
from .body.physics_base import PhysicsBase
from .body.physics_car import PhysicsCar
from .body.physics_gripper import PhysicsGripper
from .body.physics_holonomic import PhysicsHolonomicBase
from .body.robot_body import RobotBody
from .body.suspension_springs import SuspensionSprings
from .body.touch import ContactReader
from .onlooker import Onlooker
from .props_body import Pieces, PropsBody
from .scene_sync import SceneSync
from .sensors.physics_site import PhysicsSite
from .world.terrain import Terrain
from .world.world_bodies import WorldBodies

PhysicsWheels = PhysicsBase | PhysicsCar | PhysicsHolonomicBase
SETTLING_TIME_S = 0.3  # [s] that everything gets to come to rest before time begins
SETTLES_OUTDOORS = 1.5  # the same on rough ground, onto which the robot is let down
LET_DOWN = 0.01  # [m] above its highest point under the wheels
CAR_WHEELS_M = np.array(
    [[x, y] for x in (0.0, 0.6) for y in (-0.3, 0.3)]
)  # of a car, around its rear axle [m]
MAX_TILT_DEG = {"floor": 4.0, "terrain": 45.0}  # of the base; beyond it for `TIPPED_S`, it has tipped
TIPPED_S = 1.0  # a base that runs into something lifts its wheels and falls back within half a second
FALLEN_DEG = 45.0  # from where no base comes back
_FELT = 4  # of a period's looks at what touches, the last ones in which the force on the hand is measured


class PhysicsBackend(SimulatedBackend):
    """A mobile base with arm, gripper, camera and lidar in a physics engine.

    It reads the same robot and world files as the kinematic backend, with the same solids. Two driven wheels
    and frictionless casters roll on a floor, or several wheels on each side, which slide sideways when the
    base turns. Joints have drives with limited torque; two coupled fingers hold by friction; things are rigid
    bodies that rest, lean on each other and fall. A base that tilts is mounted on springs. A base that steers
    like a car drives on rough ground, which is a height field.

    Simulated errors, drawn from the seed: radius of each wheel, tread, the arm's errors, ranges, image noise,
    blur, light, lens, the force reading, and the places at which a person puts robot and things. Slip and
    compliance are results of the engine. The turn of the base on its tyres after a swing of the loaded arm is
    added, because rigid wheels do not turn in this way.

    A subclass provides the engine, the robot's body in it, and the camera. `scene` is ground truth: only
    evaluation may read it.
    """

    STATE: ClassVar[Kinds] = {**SimulatedBackend.STATE, "held_name": str | None}
    _base: PhysicsWheels
    _arm: PhysicsArm | None
    _gripper: PhysicsGripper | None

    def __init__(self, robot: RobotFile, world: WorldFile, seed: int, window: bool = False) -> None:
        """Set robot and world up; `window` shows them. The same seed gives the same run, bit for bit."""
        super().__init__(robot, world, seed)
        self._held: Thing | None = None
        self._tilted_periods = 0
        self._engine = self._start_engine(window)
        try:
            self._build(robot, world, seed)
        except BaseException:
            self._engine.close()
            raise

    @abstractmethod
    def _start_engine(self, window: bool) -> Engine:
        """Return an engine with an empty world; `window` shows it."""

    @abstractmethod
    def _load_robot(self, robot: RobotFile) -> RobotBody:
        """Return the robot's body in the engine, at the pose that its base has in the scene."""

    @cached_property
    def _onlooker(self) -> Onlooker:
        return Onlooker(self._engine)

    def _seen_from(self) -> Transform:
        """Return world_T_camera (4, 4) of the chase camera, now."""
        return self._onlooker.look(self._body.standing_pose(), self.scene.time)

    def _build(self, robot: RobotFile, world: WorldFile, seed: int) -> None:
        terrain = self._put_up(robot, world, seed)
        self._build_arm(robot, seed)
        pieces = Pieces(self._engine, self._body, self._world, self._gripper, self._grip)
        kinds = {name: self._world.kinds.of(props, None) for name, props in self.scene.props.items()}
        self._bodies: dict[str, PropsBody] = {
            name: kind(self.scene.props[name], pieces) for name, kind in kinds.items() if kind is not None
        }
        self._base = self._make_base(robot, world, seed)
        self._body.cover(self._body.casters, CASTER_SURFACE)
        self._on_floor, self._terrain = terrain is None, terrain
        site = PhysicsSite(self._engine, self._body, self._world)
        self._build_sensors(settled=False, engine=site)
        for _ in range(round((SETTLING_TIME_S if terrain is None else SETTLES_OUTDOORS) / self.period)):
            self._run_period()
        self._base.rezero()
        self._build_sensors(settled=True, engine=site)

    def _make_base(self, robot: RobotFile, world: WorldFile, seed: int) -> PhysicsWheels:
        if robot.drive.kind == "ackermann":
            return PhysicsCar(robot, self._body, self._engine.chunk, world.ground or GroundSpec())
        kind = PhysicsHolonomicBase if robot.drive.kind == "holonomic" else PhysicsBase
        return kind(robot, self._body, self._engine.chunk, seed)

    def _put_up(self, robot: RobotFile, world: WorldFile, seed: int) -> Terrain | None:
        """Build the world, and the robot's body in it; return the ground if it is rough, otherwise None."""
        engine, terrain = self._engine, None
        if robot.drive.kind == "ackermann" and world.ground is not None:
            terrain = Terrain(engine, world.ground, seed)
        self._world = WorldBodies(engine, self.scene, terrain)
        self._body = self._load_robot(robot)
        self.remarks = [robot.whole.remark("link", *repair) for repair in self._body.repairs]
        if terrain is not None:
            self.scene.ground_height = terrain.height_at
            self._body.put(self.scene.base, _highest_under(terrain, self.scene.base) + LET_DOWN)
            self._world.reach(self.scene.base.x, self.scene.base.y)
        last = robot.arm.joints[-1] if robot.arm else None
        self._touch = ContactReader(engine, self._body, self._world, last)
        self._sync = SceneSync(self.scene, self._body, self._world)
        return terrain

    def _build_arm(self, robot: RobotFile, seed: int) -> None:
        """Build the arm and its gripper."""
        self._springs: SuspensionSprings | None = None
        self._grip: Grip | None = None
        model, body, engine = self.scene.arm, self._body, self._engine
        if model is None:
            return
        for name, angle in zip(model.joint_names, self.scene.joints, strict=True):
            body.reset(name, float(angle))
        if body.sprung:
            self._springs = SuspensionSprings(robot, model, body)
        ahead = engine.chunk / 2 if engine.chunks == 1 else 0.0  # a chunk is too short to matter
        self._arm = PhysicsArm(robot, model, body, self.scene.felt_force, ahead, seed)
        if robot.gripper is not None:
            self._gripper = PhysicsGripper(
                robot.gripper, robot.errors, body, pads_in(engine), self.period, seed
            )
            self._grip = Grip(robot.gripper, finger_shape(model), engine, body)

    def link_pose(self, link: str) -> Transform:
        """Return world_T_link (4, 4), the true pose of a link's frame."""
        return self._body.link_pose(link)

    @override
    def step(self) -> None:
        self._begin_period()
        if (there := self._kidnapped_to()) is not None:
            self._carry_to(there)
        self._world.keep_time()
        self._world.reach(self.scene.base.x, self.scene.base.y)
        self._world.keep_things()
        for body in self._bodies.values():
            body.step()
        self._run_period()

    def _carry_to(self, there: Pose2) -> None:
        """Let a person set the robot down at another pose world_T_base, with all that it carries."""
        self._world.reach(there.x, there.y)
        before = self._body.standing_pose()
        under = float(before[2, 3]) if self._terrain is None else _highest_under(self._terrain, there)
        if self._grip is not None and self._grip.holds in self._world.fixed:
            self._grip.let_go()
        carried = [*self._riding(), *([self._grip.holds] if self._grip is not None else [])]
        poses = {body: self._engine.pose(body) for body in carried if body is not None}
        self._body.put(there, under + LET_DOWN)
        moved = self._body.standing_pose() @ inverse(before)
        for body, pose in poses.items():
            self._engine.set_pose(body, moved @ pose)

    def _run_period(self) -> None:
        if self._grip is not None and self._gripper is not None and self._gripper.opening:
            self._grip.let_go()
        self._base.begin(self._periods)
        for part in (self._arm, self._gripper):
            if part is not None:
                part.begin(self._periods)
        if self._arm is not None and self._arm.swung:
            self._base.give(self._arm.swing_yaw())
        held = None if self._held is None else self._world.bodies[self._held.name]
        riding = self._riding()
        chunks, felt = self._engine.chunks, np.zeros(3)
        parts = self._engine.parts()
        looks, looked = chunks * len(parts), 0
        touched: set[tuple[str, str]] = set()
        for chunk in range(chunks):
            for body in self._bodies.values():
                body.act()
            self._base.act()
            if self._springs is not None:
                self._springs.act()
            if self._gripper is not None:
                self._gripper.act((chunk + 1) / chunks)
            if self._arm is not None:
                self._arm.act(chunk / chunks, self.period)
            for steps in parts:
                self._engine.step(steps)
                self._touch.stepped()
                touched |= self._touch.pairs(held, riding)
                looked += 1
                if self._arm is not None and looked > looks - _FELT:
                    felt += self._touch.force(held) / min(_FELT, looks)
        for body in self._bodies.values():
            body.end()
        self._end_period(felt, touched)

    def _end_period(self, felt: np.ndarray, touched: Set[tuple[str, str]]) -> None:
        self._base.read()
        self._sync.base()
        if self._springs is not None:
            self.scene.lean = self._springs.lean
        self._advance_sensors()
        self._check_upright()
        if self._gripper is not None:
            self._gripper.end()
            self._held = self._find_held()
            self.scene.width = self._gripper.true_width()
        self._sync.things(self._held)
        if self._arm is not None:
            self._arm.end()
            self.scene.joints = self._arm.true_joints()
            turn = self._body.link_pose("hand")[:3, :3]
            self.scene.hand_force = turn.T @ felt
            self._arm.load = self._load()
        taken = "" if self._held is None else self._held.name
        self.scene.touch(frozenset(pair for pair in touched if pair[1] != taken))

    def _check_upright(self) -> None:
        """Raise `RobotFault` where the base has tipped and does not fall back."""
        tilt = math.degrees(math.acos(max(-1.0, min(1.0, float(self._body.base_pose()[2, 2])))))
        tilted = tilt > MAX_TILT_DEG["floor" if self._on_floor else "terrain"]
        self._tilted_periods = self._tilted_periods + 1 if tilted else 0
        if tilt > FALLEN_DEG or self._tilted_periods * self.period > TIPPED_S:
            why = "what it stands on does not carry its middle of mass, or something pushed it"
            raise RobotFault(f"the base has tipped, by {tilt:.0f} degrees: {why}; see `handcart check`")

    def _find_held(self) -> Thing | None:
        """Return the thing between fingers that press, or None."""
        if self._gripper is None or self._grip is None:
            return None
        body = self._touch.gripped()
        if body is not None and self._gripper.closed_on_something():
            self._grip.take(body)
        elif body is None and not any(item.keeps_grip for item in self._bodies.values()):
            self._grip.let_go()
        body = self._grip.holds
        if body is None:
            return None
        return next(thing for thing in self.scene.things() if self._world.bodies[thing.name] == body)

    def _load(self) -> tuple[float, np.ndarray]:
        if self._held is None:
            return 0.0, np.zeros(3)
        middle = self._held.pose @ self._held.thing_T_middle
        return self._held.mass, (inverse(self._body.base_pose()) @ middle)[:3, 3]

    def _riding(self) -> list[int]:
        """Return the engine's numbers of the things that lie on the robot."""
        return [self._world.bodies[thing.name] for thing in self.scene.riding()]

    @override
    def state(self) -> dict[str, Any]:
        return {**super().state(), "engine": self._engine.state()}

    @override
    def set_state(self, state: object) -> None:
        if not isinstance(state, dict) or "engine" not in state:
            raise NotAState(
                f"no state of this robot in {self.name}; needed: {', '.join(self._parts())}, engine"
            )
        super().set_state({name: part for name, part in state.items() if name != "engine"})
        self._tilted_periods = 0
        self._engine.set_state(state["engine"])

    @property
    def held_name(self) -> str | None:
        """Name of the thing that the fingers hold; None if the fingers hold nothing."""
        return None if self._held is None else self._held.name

    @held_name.setter
    def held_name(self, name: str | None) -> None:
        self._held = self.scene.thing_named(name)

    def _own_parts(self) -> Mapping[str, ChangingPart | None]:
        bodies = {f"body {name}": body for name, body in self._bodies.items()}
        return {"drives": self._base.drives, **bodies, "made": self._world}

    @override
    def close(self) -> None:
        for sensor in self._sensors.values():
            sensor.close()
        self._engine.close()


def _highest_under(terrain: Terrain, base: Pose2) -> float:
    """Return the largest height of the ground under the wheels of a car at world_T_base, in [m]."""
    return float(terrain.height(*base.apply(CAR_WHEELS_M).T).max())
