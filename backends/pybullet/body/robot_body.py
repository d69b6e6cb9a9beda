"""The robot as Bullet's body: its URDF loaded, its joints by name."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.pybullet.engine import quiet
from handcart.backends.pybullet.physics import ROBOT_GROUP, Physics, matrix
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.urdf_contents import joints_of
from handcart.robotics.kinematics.urdf_tree import joint_leaders

from .sprung import CHASSIS, sprung

WHEEL_FRICTION = 1.0  # rubber
SCRUBS = 0.1  # of it, along the axle of a wheel that must slide sideways for its base to turn
PAD_FRICTION = 1.5
FRICTION_SHARE = 0.5  # of it that the engine's contacts have; the rest is that of `Grip`
CASTER_STIFFNESS, CASTER_DAMPING = 1e6, 2e4
"""Of a caster on the floor, in [N/m] and [Ns/m]: it gives by 0.2 mm under 200 N. One as hard as the wheels
might take all the weight off them, and the base would slide on. Also of each of four wheels."""
PAD_STIFFNESS = 1e5  # rubber, at each corner [N/m]: rigid pads would press with one corner each
PAD_DAMPING = 1000.0  # [Ns/m]
_ALL = -1
_MOVED = ("left_finger", "right_finger", "left_steering", "right_steering")
_HOLDS = 1000.0  # what a joint that stands is held with, where the URDF doesn't say [Nm] or [N]
_SPECK = 1e-6  # mass of a link that is only a frame [kg], and its inertia [kg m²]; Bullet would take 1

Vector = NDArray[np.float64]


class RobotBody:
    """The URDF of a robot's file in a physics engine, standing on the floor.

    Where the file has the base lean, it stands on a chassis with a suspension; see `sprung`.
    """

    def __init__(self, physics: Physics, robot: RobotFile, base: Pose2) -> None:
        """Load it with `base` as world_T_base."""
        self._physics, self._p = physics, physics.p
        p, client = physics.p, physics.client
        flags = (
            p.URDF_USE_INERTIA_FROM_FILE
            | p.URDF_USE_IMPLICIT_CYLINDER
            | p.URDF_USE_SELF_COLLISION_EXCLUDE_ALL_PARENTS
        )
        self.sprung = robot.errors.lean_mrad_per_m > 0.0
        """Whether it has a suspension."""
        urdf = _on_suspension(robot) if self.sprung else robot.urdf_text()
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = robot.urdf_path()
            if self.sprung:
                path = Path(folder) / "robot.urdf"
                path.write_text(urdf, encoding="utf-8")
            self.id = int(p.loadURDF(str(path), flags=flags, physicsClientId=client))
        count = p.getNumJoints(self.id, physicsClientId=client)
        infos = [p.getJointInfo(self.id, i, physicsClientId=client) for i in range(count)]
        self.joint_index = {info[1].decode(): info[0] for info in infos}
        self.link_index = {info[12].decode(): info[0] for info in infos}
        self.link_names = {index: name for name, index in self.link_index.items()}
        self.wheels = driven_wheels(self.joint_index)
        self.wheels.check()
        self._parent = {info[0]: info[16] for info in infos}
        self.effort = {info[1].decode(): float(info[10]) for info in infos}
        root = p.getBodyInfo(self.id, physicsClientId=client)[0].decode()
        self.link_index[root], self.link_names[-1] = -1, root
        self._root_T_middle = matrix(*p.getDynamicsInfo(self.id, -1, physicsClientId=client)[3:5])
        self._middle_T_base = inverse(self._root_T_middle) @ self._root_T_base()
        for name in _without_mass(urdf):
            p.changeDynamics(
                self.id,
                self.link_index[name],
                mass=_SPECK,
                localInertiaDiagonal=(_SPECK, _SPECK, _SPECK),
                physicsClientId=client,
            )
        for link in range(-1, count):
            p.setCollisionFilterGroupMask(self.id, link, ROBOT_GROUP, _ALL, physicsClientId=client)
        for info in infos:
            if info[2] in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC):
                self.free(info[0])
        if self.sprung:
            self._pass_through_itself()
        for one, other in robot.whole.allowed:
            if {one, other} <= set(self.link_index):
                self._pass_through(one, other)
        self._hold_the_rest(robot)
        self.put(base)

    def _root_T_base(self) -> Transform:
        index = self.link_index["base"]
        if index == -1:
            return np.eye(4)
        return inverse(self._root()) @ self.link_pose("base")

    def _root(self) -> Transform:
        return self._physics.pose(self.id) @ inverse(self._root_T_middle)

    def put(self, base: Pose2, height: float = 0.0) -> None:
        """Put the base elsewhere, on the floor or at a `height` above it in [m]."""
        self._physics.set_pose(self.id, base.lift(height) @ inverse(self._middle_T_base))

    def free(self, joint: int) -> None:
        """Switch Bullet's own motor of a joint off."""
        self._p.setJointMotorControl2(
            self.id, joint, self._p.VELOCITY_CONTROL, force=0.0, physicsClientId=self._physics.client
        )

    def base_pose(self) -> Transform:
        """world_T_base (4, 4), as it truly stands."""
        return self.link_pose("base") if self.sprung else self.standing_pose()

    def standing_pose(self) -> Transform:
        """world_T_base (4, 4) as it would be if it didn't lean on a suspension."""
        return self._physics.pose(self.id) @ self._middle_T_base

    def sprung_masses(self) -> dict[str, float]:
        """Masses in [kg] of all links that the suspension carries, by name."""
        p, client = self._p, self._physics.client
        return {
            name: float(p.getDynamicsInfo(self.id, index, physicsClientId=client)[0])
            for name, index in self.link_index.items()
            if name not in (CHASSIS, *self.wheels.all, *self.casters)
        }

    def link_pose(self, link: str) -> Transform:
        """World pose (4, 4) of a link's frame."""
        index = self.link_index[link]
        if index == -1:
            return self._root()
        state = self._p.getLinkState(
            self.id, index, computeForwardKinematics=1, physicsClientId=self._physics.client
        )
        return matrix(state[4], state[5])

    def middle_of_mass(self, link: str) -> Transform:
        """World pose (4, 4) of the frame at a link's middle of mass."""
        index = self.link_index[link]
        if index == -1:
            return self._physics.pose(self.id)
        state = self._p.getLinkState(
            self.id, index, computeForwardKinematics=1, physicsClientId=self._physics.client
        )
        return matrix(state[0], state[1])

    def states(self, joints: Sequence[int]) -> tuple[Vector, Vector]:
        """Positions and velocities (n,) of joints, in [rad] or [m] and a second."""
        read = self._p.getJointStates(self.id, joints, physicsClientId=self._physics.client)
        return np.array([each[0] for each in read]), np.array([each[1] for each in read])

    def reset(self, joint: str, position: float) -> None:
        """Put a joint elsewhere, at rest."""
        self._p.resetJointState(
            self.id, self.joint_index[joint], position, physicsClientId=self._physics.client
        )

    def rub(self, links: Sequence[str], friction: float) -> None:
        """Give links a friction."""
        for link in links:
            self._p.changeDynamics(
                self.id,
                self.link_index[link],
                lateralFriction=friction,
                physicsClientId=self._physics.client,
            )

    def scrub(self, links: Sequence[str]) -> None:
        """Let wheels, their axles along y, slide sideways: those of a base that is steered by its sides.

        They share its weight as they give a little, and at rest they stick.
        """
        for link in links:
            self._p.changeDynamics(
                self.id,
                self.link_index[link],
                anisotropicFriction=(1.0, SCRUBS, 1.0),
                contactStiffness=CASTER_STIFFNESS,
                contactDamping=CASTER_DAMPING,
                frictionAnchor=1,
                physicsClientId=self._physics.client,
            )

    def pad(self, links: Sequence[str]) -> None:
        """Cover links with rubber."""
        for link in links:
            self._p.changeDynamics(
                self.id,
                self.link_index[link],
                lateralFriction=FRICTION_SHARE * PAD_FRICTION,
                contactStiffness=PAD_STIFFNESS,
                contactDamping=PAD_DAMPING,
                frictionAnchor=1,
                physicsClientId=self._physics.client,
            )

    def slide(self) -> None:
        """Let casters slide without friction, on springs: they stand for wheels that turn any way."""
        for link in self.casters:
            self._p.changeDynamics(
                self.id,
                self.link_index[link],
                lateralFriction=0.0,
                contactStiffness=CASTER_STIFFNESS,
                contactDamping=CASTER_DAMPING,
                physicsClientId=self._physics.client,
            )

    def links_behind(self, joint: str) -> set[int]:
        """Bullet's numbers of the links that a joint moves."""
        moved = {self.joint_index[joint]}
        for link in sorted(self._parent):  # Bullet numbers a parent before its children
            if self._parent[link] in moved:
                moved.add(link)
        return moved

    @property
    def casters(self) -> list[str]:
        """Links that slide on the floor."""
        return _casters(self.link_index)

    def _pass_through_itself(self) -> None:
        """Let wheels and casters stand within the base, which is no longer their parent."""
        for name in (*self.wheels.all, *self.casters):
            for other in self.link_index:
                self._pass_through(name, other)

    def _pass_through(self, one: str, other: str) -> None:
        links = self.link_index[one], self.link_index[other]
        self._p.setCollisionFilterPair(self.id, self.id, *links, 0, physicsClientId=self._physics.client)

    def _hold_the_rest(self, robot: RobotFile) -> None:
        """Have the limited joints that nobody moves (a head, another arm) stand where kinematics has them."""
        leaders = joint_leaders(robot.urdf_text())
        moved = {*(robot.arm.joints if robot.arm else ()), *_MOVED}
        for joint in joints_of(robot.urdf_text()):
            leader, _, offset = leaders.get(joint.name, (joint.name, 1.0, 0.0))
            if leader in moved or joint.kind == "continuous":
                continue
            self.reset(joint.name, offset)
            self._p.setJointMotorControl2(
                self.id,
                self.joint_index[joint.name],
                self._p.POSITION_CONTROL,
                targetPosition=offset,
                force=_HOLDS if joint.effort <= 0.0 else joint.effort,
                physicsClientId=self._physics.client,
            )


def _on_suspension(robot: RobotFile) -> str:
    text = robot.urdf_text()
    links = [link.get("name", "") for link in ElementTree.fromstring(text).findall("link")]
    return sprung(text, robot.errors.lean_pivot_m, (*driven_wheels(links).all, *_casters(links)))


def _casters(links: Iterable[str]) -> list[str]:
    return [name for name in links if "caster" in name]


def _without_mass(urdf: str) -> list[str]:
    """Links that are only frames."""
    links = ElementTree.fromstring(urdf).findall("link")
    return [link.get("name", "") for link in links if link.find("inertial") is None]
