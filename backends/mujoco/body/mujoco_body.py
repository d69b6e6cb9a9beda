"""The robot as bodies of MuJoCo's: its URDF loaded, its joints by name."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.mujoco.engine.mujoco_module import mujoco
from handcart.backends.mujoco.engine.world_spec import (
    CONTACT_COMPLIANCE,
    HOLDS_ON_SOFT,
    LINKAGE_IMPEDANCE,
    PAD_IMPEDANCE,
    ROBOT_GROUP,
    ROBOT_PREFIX,
    SOFT_GROUND_IMPEDANCE,
    TYRE_IMPEDANCE,
    quaternion,
)
from handcart.backends.physics.body.robot_body import PlanarDrive, RobotBody
from handcart.backends.physics.engine.surface import ContactSurface
from handcart.backends.physics.refusal import refusal
from handcart.backends.physics.urdf.rigid_groups import passing_pairs
from handcart.backends.physics.urdf.sound_urdf import held_still, sound_urdf
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.urdf_tree import joint_leaders

from .building import ENGINE_NAME
from .mujoco_joints import YIELDING_DRIVE_NAME, MujocoJoints
from .mujoco_urdf import read_robot
from .planar_drive import MujocoPlanarDrive, add_planar_drive
from .robot_looks import PartLook, robot_looks

TOP_ACCELERATION = 100.0  # of a drive that moves nothing but itself [rad/s²]
TOP_SLIDE_ACCELERATION = 50.0  # the same of one that slides [m/s²]
LINKS_RUB = 0.5  # Coulomb's friction of links that nothing is said about
_FOLLOWS = 0.1  # of the way to where it belongs that a joint that is held makes in a step


class MujocoBody(RobotBody):
    """A robot's links and joints in MuJoCo.

    The joints have the rotor inertia of real drives, which makes their simulated motion stable.
    """

    COUPLES_MIMICS = True

    def __init__(self, engine: MujocoEngine, robot: RobotFile, base: Pose2) -> None:
        """Load the robot with `base` as world_T_base."""
        self._engine = engine
        self.sprung = robot.errors.lean_mrad_per_m > 0.0
        self._radius = robot.footprint_radius_m
        self.id = engine.grow()
        try:
            self._load(engine, robot, base)
        except InputError:
            raise
        except ValueError as error:
            raise refusal(ENGINE_NAME, error, robot.whole, ROBOT_PREFIX) from error

    def _load(self, engine: MujocoEngine, robot: RobotFile, base: Pose2) -> None:
        self._urdf = sound_urdf(robot)
        self.repairs = self._urdf.repairs
        child = read_robot(self._urdf)
        leaders = joint_leaders(self._urdf.text)
        self.effort = {joint.name: float(joint.actfrcrange[1]) for joint in child.joints}
        self._furnish(child, robot.arm.joints if robot.arm is not None else (), leaders)
        if robot.drive.kind == "holonomic":
            add_planar_drive(child)
        spec = engine.world.spec
        spec.attach(child, prefix=ROBOT_PREFIX, frame=spec.worldbody.add_frame())
        root = next(body for body in spec.bodies if body.name.startswith(ROBOT_PREFIX))
        root.add_freejoint(name=f"{self.id}")
        root.sleep = mujoco().mjtSleepPolicy.mjSLEEP_NEVER
        self._root_name, self._root = root.name, root.name.removeprefix(ROBOT_PREFIX)
        names = [
            body.name.removeprefix(ROBOT_PREFIX) for body in spec.bodies if body.name.startswith(ROBOT_PREFIX)
        ]
        self.link_index = {name: number - 1 for number, name in enumerate(names)}
        self.link_names = {number: name for name, number in self.link_index.items()}
        self.wheels = driven_wheels(self.effort)
        if robot.drive.kind != "holonomic":
            self.wheels.check()
        for wheel in (geometry for name in self.rolling for geometry in spec.body(ROBOT_PREFIX + name).geoms):
            engine.world.bulge(wheel)
        self._leave_out(robot)
        if "hand" in self.link_index:
            engine.pins.prepare(spec, ROBOT_PREFIX + "hand", self._root_name)
        engine.name_links(self.id, {ROBOT_PREFIX + name: number for name, number in self.link_index.items()})
        self._root_T_base = inverse(self.link_pose(self._root)) @ self.link_pose("base")
        for joint, (position, force) in held_still(robot).items():
            self.reset(joint, position)
            if joint not in leaders:
                self.joints([joint]).stand(np.array([position]), np.array([force]), _FOLLOWS)
        self.put(base)

    def _furnish(self, robot: Any, arm: Collection[str], followers: Collection[str]) -> None:
        """Give each joint a drive, the arm's joints a second one, and links their default friction.

        The drives of joints that mimic another are never commanded: a linkage moves these joints.
        """
        for linkage in robot.equalities:
            linkage.solref, linkage.solimp = CONTACT_COMPLIANCE, LINKAGE_IMPEDANCE
        for geometry in robot.geoms:
            geometry.group, geometry.solref = ROBOT_GROUP, CONTACT_COMPLIANCE
            geometry.friction = (LINKS_RUB**2, 0.005, 0.0001)
        for joint in robot.joints:
            if self.effort[joint.name] <= 0.0 or joint.name in followers:
                continue
            turns = joint.type == mujoco().mjtJoint.mjJNT_HINGE
            joint.armature = self.effort[joint.name] / (TOP_ACCELERATION if turns else TOP_SLIDE_ACCELERATION)
        for joint in robot.joints:
            joint.actfrclimited = 0
            _add_drive(robot, joint.name, joint.name)
        for name in arm:
            _add_drive(robot, YIELDING_DRIVE_NAME.format(name), name)

    def _leave_out(self, robot: RobotFile) -> None:
        """Exclude contacts of links with those that carry them, that are rigid to them, or that may touch."""
        spec = self._engine.world.spec
        pairs = {frozenset(pair) for pair in robot.whole.allowed if set(pair) <= set(self.link_index)}
        pairs |= {frozenset(pair) for pair in passing_pairs(self._urdf.text, held_still(robot))}
        for name in self.link_index:
            pairs |= {frozenset((name, above)) for above in self._above(name)}
        if self.sprung:
            rolling = (*self.wheels.all, *self.casters)
            pairs |= {frozenset((name, text)) for name in rolling for text in self.link_index}
        for one, other in sorted(sorted(pair) for pair in pairs if len(pair) == 2):
            spec.add_exclude(bodyname1=ROBOT_PREFIX + one, bodyname2=ROBOT_PREFIX + other)

    def _above(self, link: str) -> Iterator[str]:
        """Yield the links that carry a link, the nearest first."""
        body = self._engine.world.spec.body(ROBOT_PREFIX + link).parent
        while body.name.startswith(ROBOT_PREFIX):
            yield body.name.removeprefix(ROBOT_PREFIX)
            body = body.parent

    def looks(self) -> list[PartLook]:
        """Return form, place and colour of the visual shapes of the robot's links, for rendering."""
        return robot_looks(partial(read_robot, self._urdf))

    # Readings of the body

    @override
    def put(self, base: Pose2, height: float = 0.0) -> None:
        pose = base.lift(height) @ inverse(self._root_T_base)
        joint, data = self._engine.model.joint(f"{self.id}"), self._engine.data
        at, speed = int(joint.qposadr[0]), int(joint.dofadr[0])
        data.qpos[at : at + 7] = np.concatenate([pose[:3, 3], quaternion(pose)])
        data.qvel[speed : speed + 6] = 0.0
        self._engine.displaced()

    @override
    def standing_pose(self) -> Transform:
        return self.link_pose(self._root) @ self._root_T_base

    @override
    def link_pose(self, link: str) -> Transform:
        data, index = self._engine.links(), self._body(link)
        return _pose(data.xpos[index], data.xmat[index])

    @override
    def middle_of_mass(self, link: str) -> Transform:
        data, index = self._engine.links(), self._body(link)
        return _pose(data.xipos[index], data.ximat[index])

    @override
    def mass(self, link: str) -> float:
        return float(self._engine.model.body_mass[self._body(link)])

    def _body(self, link: str) -> int:
        return self._engine.link_body(self.id, self.link_index[link])

    # Commands to the body

    @override
    def joints(self, names: Sequence[str]) -> MujocoJoints:
        return MujocoJoints(self._engine, [ROBOT_PREFIX + name for name in names])

    @override
    def planar_drive(self) -> PlanarDrive:
        mass = sum(map(self.mass, self.link_index))
        inertia = mass * self._radius**2 / 2.0
        return MujocoPlanarDrive(self._engine, mass, inertia, ROBOT_PREFIX)

    @override
    def reset(self, joint: str, position: float) -> None:
        found, data = self._engine.model.joint(ROBOT_PREFIX + joint), self._engine.data
        data.qpos[found.qposadr[0]], data.qvel[found.dofadr[0]] = position, 0.0
        self._engine.displaced()

    def cover(self, links: Iterable[str], surface: ContactSurface) -> None:
        """Set friction, compliance and stiction of the contact surface of links.

        Args:
            links: names of the links.
            surface: contact properties.
        """
        spec = self._engine.world.spec
        for link, geometry in [
            (name, geom) for name in links for geom in spec.body(ROBOT_PREFIX + name).geoms
        ]:
            if surface.friction is not None:
                geometry.priority = 1  # its friction alone counts for a pair
                geometry.friction = (surface.friction * surface.against, 0.005, 0.0001)
            if surface.sticks:
                geometry.solimp = TYRE_IMPEDANCE if link in self.rolling else PAD_IMPEDANCE
            if surface.along_axle is not None:
                self._engine.world.scrub(geometry, surface.along_axle)
        self._engine.changed()
        if surface.sinks > 0.0:
            self._soften(links, surface)

    def _soften(self, links: Iterable[str], surface: ContactSurface) -> None:
        """Make the ground under links compliant, as `SOFT_GROUND_IMPEDANCE` defines."""
        world, model = self._engine.world, self._engine.model
        world.spec.option.impratio = HOLDS_ON_SOFT
        for link in links:
            easy = float(
                model.body(ROBOT_PREFIX + link).invweight0[0]
            )  # [1/kg]: MuJoCo's stiffness is one for it
            assert surface.point_stiffness is not None
            stiffness = surface.point_stiffness * (1.0 - SOFT_GROUND_IMPEDANCE[0]) * easy
            for geometry in world.spec.body(ROBOT_PREFIX + link).geoms:
                geometry.solimp, geometry.solref = SOFT_GROUND_IMPEDANCE, (-stiffness, -2.0 * stiffness**0.5)
        self._engine.changed()

    @override
    def mirror(self, joints: tuple[str, str]) -> None:
        one, other = (ROBOT_PREFIX + name for name in joints)
        linkage = self._engine.world.spec.add_equality(name1=one, name2=other)
        linkage.type, linkage.objtype = mujoco().mjtEq.mjEQ_JOINT, mujoco().mjtObj.mjOBJ_JOINT
        linkage.data[:5], linkage.solref = (0.0, 1.0, 0.0, 0.0, 0.0), CONTACT_COMPLIANCE
        self._engine.changed()

    @override
    def links_behind(self, joint: str) -> set[int]:
        moved = self._engine.world.spec.joint(ROBOT_PREFIX + joint).parent
        names = [moved.name, *(item.name for item in moved.find_all("body"))]
        return {self.link_index[name.removeprefix(ROBOT_PREFIX)] for name in names}


def _add_drive(robot: Any, name: str, joint: str) -> None:
    """Add a drive to a joint of the `MjSpec`; it applies no effort before `MujocoJoints` commands it."""
    drive = robot.add_actuator(name=name, target=joint)
    drive.trntype = mujoco().mjtTrn.mjTRN_JOINT
    drive.dyntype = mujoco().mjtDyn.mjDYN_INTEGRATOR
    drive.biastype = mujoco().mjtBias.mjBIAS_AFFINE
    drive.forcelimited, drive.forcerange = 1, (-1e-9, 1e-9)


def _pose(position: Any, turn: Any) -> Transform:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), position
    return pose
