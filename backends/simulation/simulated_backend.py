"""The base class of the backends that simulate a robot and its world."""

from __future__ import annotations

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
from handcart.backends.simulation.sensors.simulated_beacons import SimulatedBeacons
from handcart.backends.simulation.sensors.simulated_camera import SimulatedCamera
from handcart.backends.simulation.sensors.simulated_gps import SimulatedGps
from handcart.backends.simulation.sensors.simulated_imu import SimulatedImu
from handcart.backends.simulation.sensors.simulated_positioning import SimulatedPositioning
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.backends.simulation.world.load_world import load_world, load_world_or_map
from handcart.backends.simulation.world.solids import THE_GROUND, room_of
from handcart.backends.simulation.world.world_file import MissingWorld, WorldFile, floor_pose
from handcart.backends.simulation.world.world_model import kinds_of_props
from handcart.robotics.geometry.pose2 import Pose2

from .keyed_noise import keyed
from .scene import Scene

CapabilityT = TypeVar("CapabilityT", bound=Capability)


class Part(Protocol):
    """Something that changes in a run."""

    @property
    def STATE(self) -> Kinds:
        """Attributes that a checkpoint keeps, with their types; attributes derived from them are not kept."""


class SimulatedBackend(Backend):
    """A robot among simulated things, with its parts, and the true poses of all of them.

    A subclass gives the robot its parts when it is built, and lets periods pass in `step`. `scene` is
    ground truth: only evaluation may read it.
    """

    STATE: ClassVar[Kinds] = {"_periods": int}
    _base: CommandedBase

    def __init__(self, robot: RobotFile, world: WorldFile, seed: int) -> None:
        """Set the world up, with a robot in it that has no parts yet."""
        self.period = robot.period_s
        self.scene = build_scene(robot, world, seed)
        self._robot, self._world_file, self._seed = robot, world, seed
        self._periods = 0
        self._arm: SimulatedArm | None = None
        self._gripper: SimulatedGripper | None = None
        self._camera: SimulatedCamera | None = None
        self._range: SimulatedRangeSensor | None = None
        self._imu: SimulatedImu | None = None
        self._gps: SimulatedGps | None = None
        self._beacons: SimulatedBeacons | None = None
        self._positioning: SimulatedPositioning | None = None
        self._by_kind: dict[type[Capability], Capability] = {}

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
        """Return the world with the robot at `start` (world_T_base) at first."""
        return world.model_copy(update={"start": floor_pose(start)})

    @classmethod
    def needed(cls, world: Path | WorldFile | None) -> WorldFile:
        """Return the world, read first if it is a path.

        Raises:
            MissingWorld: no world is given.
            FileError: the world's file is missing or invalid.
        """
        if world is None:
            raise MissingWorld(f"the backend {cls.name!r} simulates; needed: a world file")
        return world if isinstance(world, WorldFile) else load_world(world)

    def _receive(self) -> None:
        """Build the sensors that locate the base by external signals: satellites, beacons."""
        if self._robot.gps is not None:
            sky = self._world_file.sky
            self._gps = SimulatedGps(self._robot.gps, sky, self.scene, self.period, self._seed)
        if self._robot.beacons is not None:
            spec, there = self._robot.beacons, self._world_file.beacons
            self._beacons = SimulatedBeacons(spec, there, self.scene, self.period, self._seed)

    def _position(self) -> None:
        """Build the indoor positioning: it measures at once."""
        if self._robot.positioning is not None:
            spec = self._robot.positioning
            self._positioning = SimulatedPositioning(spec, self.scene, self.period, self._seed)

    def get(self, kind: type[CapabilityT]) -> CapabilityT | None:
        """See `Backend`; asked many times a period."""
        known = self._by_kind.get(kind)
        if known is None:
            known = super().get(kind)
            if known is not None:
                self._by_kind[kind] = known
        return known  # type: ignore[return-value]

    @override
    def capabilities(self) -> tuple[Capability, ...]:
        sensors = (self._camera, self._range, self._imu, self._gps, self._beacons, self._positioning)
        parts = (self._base, self._arm, self._gripper, *sensors)
        return tuple(part for part in parts if part is not None)

    @override
    def stop(self) -> None:
        for part in (self._base, self._arm, self._gripper):
            if part is not None:
                part.halt()

    def _own_parts(self) -> Mapping[str, Part | None]:
        """Return further parts that change in a run, by name; None for those that this robot does not
        have.
        """
        return {}

    def _parts(self) -> dict[str, Part]:
        """Return the parts that change in a run, by name, in the order in which they are restored."""
        named = {
            **{f"props {name}": props for name, props in self.scene.props.items()},
            "scene": self.scene,
            "backend": self,
            "base": self._base,
            "arm": self._arm,
            "gripper": self._gripper,
            "camera": self._camera,
            "range": self._range,
            "imu": self._imu,
            "gps": self._gps,
            "beacons": self._beacons,
            "positioning": self._positioning,
            **self._own_parts(),
        }
        return {name: part for name, part in named.items() if part is not None}

    @override
    def state(self) -> dict[str, Any]:
        return {name: attributes(part, part.STATE) for name, part in self._parts().items()}

    @override
    def set_state(self, state: object) -> None:
        parts = self._parts()
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
    """The world at first: a person has put the robot there, and set up what the file has of domains."""
    assert world.map is None, "load_world puts what the map shows among the furniture"
    named = world.model_fields_set - WorldFile.model_fields.keys()
    kinds = {
        name: kind
        for name, kind in (kinds_of_props() if named else {}).items()
        if named & kind.section.model_fields.keys()
    }
    room = [*room_of(world), *([THE_GROUND] if world.ground is not None else [])]
    solids = {name: kind.solids(world) for name, kind in kinds.items()}
    boxes = (each for name, kind in kinds.items() if not kind.PAINTS_SOLIDS for each in solids[name])
    arm = None if robot.arm is None else robot.arm_model()
    joints = np.zeros(0) if robot.arm is None else np.array(robot.posture("home"))
    width = 0.0 if robot.gripper is None else robot.gripper.opening_mm / 1e3
    every = (*room, *(solid for each in solids.values() for solid in each))
    scene = Scene(robot, arm, every, _start(robot, world, seed), joints, width, (*room, *boxes))
    scene.open_ground = world.ground is not None
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
