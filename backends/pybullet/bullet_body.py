"""The robot as Bullet's body: its URDF loaded, its joints by name."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.body.robot_body import RobotBody
from handcart.backends.physics.engine.surface import ContactSurface
from handcart.backends.physics.refusal import refusal
from handcart.backends.physics.urdf.rigid_groups import passing_pairs
from handcart.backends.physics.urdf.sound_urdf import held_still, sound_urdf
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse

from .bullet import quiet
from .bullet_engine import ROBOT_GROUP, BulletEngine
from .bullet_joints import BulletJoints
from .bullet_pose import matrix

_ALL = -1
_GEAR_FORCE = 500.0  # with which a linkage keeps two joints alike [N]


class BulletBody(RobotBody):
    """Links and joints of a robot in PyBullet, with methods to read their poses and to move them."""

    def __init__(self, engine: BulletEngine, robot: RobotFile, base: Pose2) -> None:
        """Load the robot with `base` as world_T_base."""
        self._engine, self._p = engine, engine.p
        p, client = engine.p, engine.client
        flags = (
            p.URDF_USE_INERTIA_FROM_FILE
            | p.URDF_USE_IMPLICIT_CYLINDER
            | p.URDF_USE_SELF_COLLISION_EXCLUDE_ALL_PARENTS
        )
        self.sprung = robot.errors.lean_mrad_per_m > 0.0
        sound = sound_urdf(robot)
        self.repairs = sound.repairs
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "robot.urdf"
            path.write_text(sound.text, encoding="utf-8")
            for name, hull in sound.hulls.items():
                (Path(folder) / name).write_text(hull.obj(), encoding="utf-8")
            try:
                self.id = int(p.loadURDF(str(path), flags=flags, physicsClientId=client))
            except p.error as error:
                raise refusal("PyBullet", error, robot.whole) from error
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
        for link in range(-1, count):
            p.setCollisionFilterGroupMask(self.id, link, ROBOT_GROUP, _ALL, physicsClientId=client)
        for info in infos:
            if info[2] in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC):
                self.free(info[0])
        if self.sprung:
            self._pass_through_itself()
        for one, other in (*robot.whole.allowed, *passing_pairs(sound.text, held_still(robot))):
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
        return self._engine.pose(self.id) @ inverse(self._root_T_middle)

    @override
    def put(self, base: Pose2, height: float = 0.0) -> None:
        self._engine.set_pose(self.id, base.lift(height) @ inverse(self._middle_T_base))

    def free(self, joint: int) -> None:
        """Switch off the motor that Bullet gives to each joint by default, for the joint with Bullet's number
        `joint`.
        """
        self._p.setJointMotorControl2(
            self.id, joint, self._p.VELOCITY_CONTROL, force=0.0, physicsClientId=self._engine.client
        )

    @override
    def standing_pose(self) -> Transform:
        return self._engine.pose(self.id) @ self._middle_T_base

    @override
    def mass(self, link: str) -> float:
        index = self.link_index[link]
        return float(self._p.getDynamicsInfo(self.id, index, physicsClientId=self._engine.client)[0])

    @override
    def link_pose(self, link: str) -> Transform:
        index = self.link_index[link]
        if index == -1:
            return self._root()
        state = self._p.getLinkState(
            self.id, index, computeForwardKinematics=1, physicsClientId=self._engine.client
        )
        return matrix(state[4], state[5])

    @override
    def middle_of_mass(self, link: str) -> Transform:
        index = self.link_index[link]
        if index == -1:
            return self._engine.pose(self.id)
        state = self._p.getLinkState(
            self.id, index, computeForwardKinematics=1, physicsClientId=self._engine.client
        )
        return matrix(state[0], state[1])

    @override
    def joints(self, names: Sequence[str]) -> BulletJoints:
        return BulletJoints(self._engine, self.id, [self.joint_index[name] for name in names])

    @override
    def reset(self, joint: str, position: float) -> None:
        self._p.resetJointState(
            self.id, self.joint_index[joint], position, physicsClientId=self._engine.client
        )

    @override
    def cover(self, links: Iterable[str], surface: ContactSurface) -> None:
        asked: dict[str, Any] = {
            "lateralFriction": surface.friction,
            "anisotropicFriction": None if surface.along_axle is None else (1.0, surface.along_axle, 1.0),
            "contactStiffness": surface.point_stiffness,
            "contactDamping": surface.damping,
            "frictionAnchor": 1 if surface.sticks else None,
        }
        given = {name: value for name, value in asked.items() if value is not None}
        for link in links:
            self._p.changeDynamics(
                self.id, self.link_index[link], **given, physicsClientId=self._engine.client
            )

    @override
    def mirror(self, joints: tuple[str, str]) -> None:
        one, other = (self.joint_index[name] for name in joints)
        p, client = self._p, self._engine.client
        nowhere = (0, 0, 0)
        gear = p.createConstraint(
            self.id, one, self.id, other, p.JOINT_GEAR, (0, 1, 0), nowhere, nowhere, physicsClientId=client
        )
        force = _GEAR_FORCE / self._engine.substeps
        p.changeConstraint(gear, gearRatio=-1, maxForce=force, erp=0.8, physicsClientId=client)

    @override
    def links_behind(self, joint: str) -> set[int]:
        moved = {self.joint_index[joint]}
        for link in sorted(self._parent):  # Bullet numbers a parent before its children
            if self._parent[link] in moved:
                moved.add(link)
        return moved

    def _pass_through_itself(self) -> None:
        """Let wheels and casters overlap the base, which Bullet no longer treats as their parent."""
        for name in (*self.wheels.all, *self.casters):
            for other in self.link_index:
                self._pass_through(name, other)

    def _pass_through(self, one: str, other: str) -> None:
        links = self.link_index[one], self.link_index[other]
        self._p.setCollisionFilterPair(self.id, self.id, *links, 0, physicsClientId=self._engine.client)

    def _hold_the_rest(self, robot: RobotFile) -> None:
        """Hold the limited joints that nothing drives at the positions that kinematics assumes."""
        for name, (position, force) in held_still(robot).items():
            self.reset(name, position)
            self._p.setJointMotorControl2(
                self.id,
                self.joint_index[name],
                self._p.POSITION_CONTROL,
                targetPosition=position,
                force=force,
                physicsClientId=self._engine.client,
            )
