"""Random arms with joints that mimic others, for `mimics`: their URDF and where their links are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.robotics.numerics.arrays import FloatArray

JOINT_KINDS = ("revolute", "prismatic", "continuous")
LEADER_COUNT = 3
MULTIPLIER_RANGE = (-3.0, 2.0)
INERTIAL_TEMPLATE = (
    '<inertial><mass value="{m}"/><inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="{i}"/></inertial>'
)
WIDE_LIMIT = '<limit lower="-10" upper="10" effort="{effort}" velocity="10"/>'
"""Limit of following joints: a tighter one could stop their leader."""
JOINT_LIMITS = {
    "revolute": '<limit lower="-2" upper="2" effort="{effort}" velocity="3"/>',
    "prismatic": '<limit lower="-0.3" upper="0.3" effort="{effort}" velocity="1"/>',
    "continuous": '<limit effort="{effort}" velocity="3"/>',
}
ROBOT_TEMPLATE = """\
format: handcart-robot/1
urdf: robot.urdf
links: {{hand: {hand}}}
allowed_contacts: []
drive: {{wheel_radius_m: 0.1, tread_m: 0.6, top_speed_m_s: 0.5, top_turn_deg_s: 60, acceleration_m_s2: 0.5,
        turn_acceleration_deg_s2: 90}}
period_s: 0.05
footprint_radius_m: 0.5
localizer: odometry
arm: {{joints: [{joints}], top_speed_deg_s: 60, acceleration_deg_s2: 120, slide_speed_mm_s: 200,
      slide_acceleration_mm_s2: 500, postures: {{home: [{zeros}]}}}}
errors: {{none: true}}
tolerance: {{base_mm: 25, base_deg: 1.5, joints_deg: 0.3, gripper_mm: 1, object_mm: 8}}
"""


class Mimic(NamedTuple):
    """Leader of a following joint, with multiplier and offset."""

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """A joint and the link of the same name that it moves."""

    name: str
    kind: str
    parent: str
    origin: FloatArray
    """parent_T_child (4, 4) at zero."""
    axis: FloatArray
    mimic: Mimic | None

    def pose(self, value: float) -> FloatArray:
        """parent_T_child (4, 4) at a position in [rad] or [m]."""
        motion = np.eye(4)
        if self.kind == "prismatic":
            motion[:3, 3] = value * self.axis
        else:
            motion[:3, :3] = Rotation.from_rotvec(value * self.axis).as_matrix()
        return np.asarray(self.origin @ motion)

    @property
    def _own_effort(self) -> int:
        """Makers state an effort of joints that follow, or none."""
        return 60 if self.name.startswith("aa") else 0

    def xml(self, effort: float) -> str:
        """Return the joint as URDF text."""
        rpy = Rotation.from_matrix(self.origin[:3, :3]).as_euler("xyz")
        parts = [
            f'<parent link="{self.parent}"/><child link="{self.name}"/>',
            f'<origin xyz="{_words(self.origin[:3, 3])}" rpy="{_words(rpy)}"/>',
            f'<axis xyz="{_words(self.axis)}"/>',
            JOINT_LIMITS[self.kind].format(effort=effort)
            if self.mimic is None
            else WIDE_LIMIT.format(effort=self._own_effort),
        ]
        if self.mimic is not None:
            leader, factor, offset = self.mimic
            parts.append(f'<mimic joint="{leader}" multiplier="{factor!r}" offset="{offset!r}"/>')
        link = f'<link name="{self.name}">{INERTIAL_TEMPLATE.format(m=0.2, i=0.001)}</link>'
        return f'{link}<joint name="{self.name}" type="{self.kind}">{"".join(parts)}</joint>'


class MimicRobot:
    """A base on wheels, and on it a random tree of joints, of which some follow others."""

    def __init__(self, seed: int, followers: int = 3, mimics: bool = True) -> None:
        """`mimics`: whether they follow; otherwise they are fixed where they would be at the start."""
        rng = np.random.default_rng(seed)
        self.leaders = [f"lead_{number}" for number in range(LEADER_COUNT)]
        led = [f"{rng.choice(['aa', 'zz'])}_follow_{number}" for number in range(followers)]
        names = [*self.leaders, *led]
        rng.shuffle(names)
        self.joints: list[Joint] = []
        for name in names:
            parent = str(rng.choice(["base", *(joint.name for joint in self.joints)]))
            leader = str(rng.choice(self.leaders))
            factor, offset = float(rng.uniform(*MULTIPLIER_RANGE)), float(rng.uniform(-0.3, 0.3))
            mimic = None if name in self.leaders else Mimic(leader, round(factor, 3), round(offset, 3))
            origin = np.eye(4)
            origin[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
            origin[:3, 3] = rng.uniform(-0.1, 0.1, 3) + ((0.0, 0.0, 0.8) if parent == "base" else 0.0)
            axis = rng.standard_normal(3)
            kind = str(rng.choice(JOINT_KINDS))
            self.joints.append(Joint(name, kind, parent, origin, axis / np.linalg.norm(axis), mimic))
        self.kinds = {joint.name: joint.kind for joint in self.joints}
        self.mimics = mimics

    def values(self, posture: FloatArray) -> dict[str, float]:
        """Positions of all joints for those of the leaders (n,)."""
        led = dict(zip(self.leaders, posture.tolist(), strict=True))
        for joint in self.joints:
            if joint.mimic is not None:
                leader, factor, offset = joint.mimic
                led[joint.name] = factor * led[leader] + offset
        return led

    def link_poses(self, posture: FloatArray) -> dict[str, FloatArray]:
        """base_T_link (4, 4) of all links, by multiplying out the tree."""
        values, poses = self.values(posture), {"base": np.eye(4)}
        for joint in self.joints:
            poses[joint.name] = poses[joint.parent] @ joint.pose(values[joint.name])
        return poses

    def goal(self, seed: int) -> FloatArray:
        """Return a posture (n,) of the leaders."""
        drawn = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, LEADER_COUNT)
        scales = [0.2 if self.kinds[name] == "prismatic" else 1.0 for name in self.leaders]
        return np.asarray(drawn * np.array(scales))

    def write(self, folder: Path) -> Path:
        """Write URDF and robot's file; return the latter."""
        joints = "".join(self._still(joint) if not self.mimics else joint.xml(60.0) for joint in self.joints)
        (folder / "robot.urdf").write_text(f'<robot name="r">{_base()}{joints}</robot>', encoding="utf-8")
        words = {"joints": ", ".join(self.leaders), "zeros": ", ".join(["0"] * LEADER_COUNT)}
        (folder / "robot.yaml").write_text(
            ROBOT_TEMPLATE.format(hand=self.leaders[-1], **words), encoding="utf-8"
        )
        return folder / "robot.yaml"

    def _still(self, joint: Joint) -> str:
        """Return a joint without its mimic, fixed where that would have it at first."""
        if joint.mimic is None:
            return joint.xml(60.0)
        fixed = Joint(joint.name, "fixed", joint.parent, joint.pose(joint.mimic.offset), joint.axis, None)
        rpy = Rotation.from_matrix(fixed.origin[:3, :3]).as_euler("xyz")
        return (
            f'<link name="{joint.name}">{INERTIAL_TEMPLATE.format(m=0.2, i=0.001)}</link>'
            f'<joint name="{joint.name}" type="fixed"><parent link="{joint.parent}"/>'
            f'<child link="{joint.name}"/>'
            f'<origin xyz="{_words(fixed.origin[:3, 3])}" rpy="{_words(rpy)}"/></joint>'
        )


def _base() -> str:
    body = INERTIAL_TEMPLATE.format(m=60, i=3)
    text = f'<link name="base">{body}</link>'
    for side, y in (("left", 0.3), ("right", -0.3)):
        text += (
            f'<link name="{side}_wheel">{INERTIAL_TEMPLATE.format(m=1, i=0.01)}'
            f'<collision><origin rpy="1.5707963 0 0"/>'
            f'<geometry><cylinder radius="0.1" length="0.04"/></geometry></collision></link>'
            f'<joint name="{side}_wheel" type="continuous"><parent link="base"/><child link="{side}_wheel"/>'
            f'<origin xyz="0 {y} 0.1"/><axis xyz="0 1 0"/><limit effort="40" velocity="20"/></joint>'
        )
    for number, x in enumerate((0.4, -0.4)):
        text += (
            f'<link name="caster_{number}">{INERTIAL_TEMPLATE.format(m=0.2, i=0.001)}<collision>'
            f'<geometry><sphere radius="0.05"/></geometry></collision></link>'
            f'<joint name="caster_{number}" type="fixed"><parent link="base"/><child link="caster_{number}"/>'
            f'<origin xyz="{x} 0 0.05"/></joint>'
        )
    return text


def _words(numbers: FloatArray) -> str:
    return " ".join(repr(float(number)) for number in numbers)
