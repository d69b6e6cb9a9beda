"""The base class of the backends that simulate a robot and its world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.capability import Capability
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ground_truth import GroundTruth
from handcart.backends.plain_values import Kinds, attributes, set_attributes
from handcart.backends.saved_state import NotAState
from handcart.backends.simulation.body.simulated_parts import CommandedBase, SimulatedArm, SimulatedGripper
from handcart.backends.simulation.noise.keyed_noise import keyed, sensor_seed
from handcart.backends.simulation.passers.passers import Passers
from handcart.backends.simulation.sensors.sensor_making import make_sensors
from handcart.backends.simulation.sensors.simulated_sensor import SensorSite, SimulatedSensor
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world.solids import THE_GROUND, room_of
from handcart.backends.simulation.world.world_file import MissingWorld, WorldFile, floor_pose
from handcart.backends.simulation.world_files.load_world import load_world, load_world_or_map
from handcart.backends.simulation.world_files.world_model import kinds_of_props
from handcart.robotics.geometry.pose2 import Pose2

CapabilityT = TypeVar("CapabilityT", bound=Capability)

OLD_PARTS = {
    "range": "sensor range_sensor",
    **{name: f"sensor {name}" for name in ("camera", "imu", "gps", "beacons", "positioning")},
}
"""Present names of sensor parts, by their names in older checkpoints."""


class ChangingPart(Protocol):
    """Base class of a backend's parts that have a state to save in checkpoints and to restore."""

    @property
    def STATE(self) -> Kinds:
        """Attributes that a checkpoint keeps, with their types; attributes derived from them are not kept."""


class SimulatedBackend(Backend):
    """Base class of backends that simulate a robot, its base, arm and sensors, in a world with things.

    A subclass creates the robot's parts when it is built, and simulates one control period in `step`.
    `scene` has the true poses of the robot and all things: only evaluation may read it.
    """

    STATE: ClassVar[Kinds] = {"_periods": int}
    SIMULATIONS: ClassVar[tuple[str, ...]] = ("scene",)
    """Names under which kinds of sensors are simulated for this backend, the most special one first."""
    _base: CommandedBase

    def __init__(self, robot: RobotFile, world: WorldFile, seed: int) -> None:
        """Set the world up, with a robot in it that has no parts yet."""
        self.period = robot.period_s
        self.scene = build_scene(robot, world, seed)
        self._robot, self._world_file, self._seed = robot, world, seed
        self._periods = 0
        self._arm: SimulatedArm | None = None
        self._gripper: SimulatedGripper | None = None
        self._sensors: dict[str, SimulatedSensor] = {}
        self._by_kind: dict[type[Capability], Capability | None] = {}

    @classmethod
    @override
    def build(cls, robot: RobotFile, world: Path | WorldFile | None, seed: int) -> SimulatedBackend:
        return cls(robot, cls.needed(world), seed)

    @classmethod
    @override
    def read_world(cls, path: Path, start: Pose2) -> WorldFile:
        return load_world_or_map(path, start)

    @classmethod
    def with_start(cls, world: WorldFile, start: Pose2) -> WorldFile:
        """Return a copy of the world in which the robot starts at `start` (world_T_base)."""
        return world.model_copy(update={"start": floor_pose(start)})

    @classmethod
    def needed(cls, world: Path | WorldFile | None) -> WorldFile:
        """Return the world; if it is given as a path, load it from that file.

        Raises:
            MissingWorld: no world is given.
            FileError: the world's file is missing or invalid.
        """
        if world is None:
            raise MissingWorld(f"the backend {cls.name!r} simulates; needed: a world file")
        return world if isinstance(world, WorldFile) else load_world(world)

    def _build_sensors(self, settled: bool, engine: object = None) -> None:
        """Build the robot's sensors.

        Args:
            settled: False to build those that may be built before everything has come to rest, True for the
                others.
            engine: object that sensors of this simulation receive next to the scene.
        """
        for name, make in make_sensors(self._robot, self.SIMULATIONS, self.name).items():
            if make.settled_first is settled:
                self._sensors[name] = make(self._site(name, engine))
        self._by_kind.clear()

    def _site(self, name: str, engine: object) -> SensorSite[Any]:
        spec = self._robot.sensors[name]
        return SensorSite(
            name=name,
            spec=spec,
            robot=self._robot,
            world=self._world_file,
            scene=self.scene,
            period=self.period,
            seed=sensor_seed(self._seed, name),
            joints=lambda: np.zeros(0) if self._arm is None else self._arm.joints(),
            link=self._robot.link_of(spec),
            engine=engine,
        )

    def _advance_sensors(self) -> None:
        for sensor in self._sensors.values():
            sensor.advance(self._periods)

    def get(self, kind: type[CapabilityT]) -> CapabilityT | None:
        """Return the robot's part that implements an interface such as `Arm` (a capability); None if the
        robot has no such part. The result is cached, because it is requested many times in a period.
        """
        if kind not in self._by_kind:
            self._by_kind[kind] = super().get(kind)
        return self._by_kind[kind]  # type: ignore[return-value]

    def _kidnapped_to(self) -> Pose2 | None:
        """Return where a person sets the robot down in this period (world_T_base), or None."""
        kidnap = self._world_file.kidnap
        if kidnap is None or self._periods != max(1, round(kidnap.at_s / self.period)):
            return None
        return Pose2(kidnap.to.x_m, kidnap.to.y_m, math.radians(kidnap.to.heading_deg))

    def _begin_period(self) -> None:
        """Begin a period: set the scene's time to its end, and let the props and the passers move for it."""
        scene = self.scene
        self._periods += 1
        scene.time = self._periods * self.period
        for props in scene.props.values():
            props.step()
        if scene.passers:
            scene.passers.advance(scene.time, self.period, scene.base, self._robot.footprint_radius_m)

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        sensors = (sensor for sensor in self._sensors.values() if isinstance(sensor, Capability))
        parts = (self._base, self._arm, self._gripper, *sensors)
        return tuple(part for part in parts if part is not None)

    @override
    def stop(self) -> None:
        for part in (self._base, self._arm, self._gripper):
            if part is not None:
                part.halt()

    def _own_parts(self) -> Mapping[str, ChangingPart | None]:
        """Return further parts that change in a run, by name; None for those that this robot does not
        have.
        """
        return {}

    def _parts(self) -> dict[str, ChangingPart]:
        """Return the parts that change in a run, by name, in the order in which they are restored."""
        named = {
            **{f"props {name}": props for name, props in self.scene.props.items()},
            "scene": self.scene,
            "passers": self.scene.passers or None,
            "backend": self,
            "base": self._base,
            "arm": self._arm,
            "gripper": self._gripper,
            **{f"sensor {name}": sensor for name, sensor in self._sensors.items()},
            **self._own_parts(),
        }
        return {name: part for name, part in named.items() if part is not None}

    @override
    def state(self) -> dict[str, Any]:
        return {name: attributes(part, part.STATE) for name, part in self._parts().items()}

    @override
    def set_state(self, state: object) -> None:
        parts = self._parts()
        if isinstance(state, dict):
            state = {OLD_PARTS.get(name, name): part for name, part in state.items()}
        if not isinstance(state, dict) or state.keys() != parts.keys():
            raise NotAState(f"no state of this robot in {self.name}; needed: {', '.join(parts)}")
        for name, part in parts.items():
            set_attributes(part, part.STATE, state[name])

    @override
    def true_base(self) -> Pose2:
        return self.scene.base

    @override
    def ground_truth(self) -> GroundTruth:
        return self.scene.truth()


def build_scene(robot: RobotFile, world: WorldFile, seed: int) -> Scene:
    """Return the true state of a world at its start: the robot, and all objects where a person put them.

    Args:
        robot: robot file.
        world: world as `load_world` returns it, with the occupied cells of its map as solid furniture.
        seed: seed of a person's errors of placement, and of all random numbers of the objects.
    """
    assert world.map is None, "load_world puts what the map shows among the furniture"
    named = world.model_fields_set - WorldFile.model_fields.keys()
    kinds = {
        name: kind
        for name, kind in (kinds_of_props() if named else {}).items()
        if named & kind.section.model_fields.keys()
    }
    room = [*room_of(world), *([THE_GROUND] if world.ground is not None else [])]
    solids = {name: kind.solids(world) for name, kind in kinds.items()}
    boxes = (item for name, kind in kinds.items() if not kind.PAINTS_SOLIDS for item in solids[name])
    arm = None if robot.arm is None else robot.arm_model()
    joints = np.zeros(0) if robot.arm is None else np.array(robot.posture("home"))
    width = 0.0 if robot.gripper is None else robot.gripper.opening_mm / 1e3
    every = (*room, *(solid for item in solids.values() for solid in item))
    scene = Scene(robot, arm, every, _start(robot, world, seed), joints, width, (*room, *boxes))
    scene.start = scene.base
    scene.open_ground = world.ground is not None
    scene.passers = Passers(world.passers, seed)
    for name, kind in kinds.items():
        props = scene.props[name] = kind(scene, world, seed)
        props.set_up()
    return scene


def _start(robot: RobotFile, world: WorldFile, seed: int) -> Pose2:
    dx, dy, turn = keyed(seed, "start").standard_normal(3)
    error = robot.errors.start_mm / 1e3
    heading = np.radians(world.start.heading_deg + robot.errors.start_deg * turn)
    x, y = world.start.x_m + error * dx, world.start.y_m + error * dy
    return Pose2(float(x), float(y), float(heading))
