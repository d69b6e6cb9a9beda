"""The URDF of a robot as engines get it, and which of its joints and links are what."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.urdf.collision_hulls import FLOOR_CLEARANCE_M, HullMesh, with_hulls
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_tree import joint_leaders

from .rigid_groups import floor_T_body_links
from .round_wheels import with_round_wheels
from .sprung import sprung
from .urdf_repairs import Repair, repaired
from .wheel_effort import with_wheel_efforts

MOVED_JOINTS = ("left_finger", "right_finger", "left_steering", "right_steering")
"""Joints that are moved, besides the arm's and the wheels'."""
ROCKER_JOINTS = ("left_rocker", "right_rocker")
"""Passive joints of a suspension, with opposite axes: a differential keeps them equal."""
# effort that holds a joint at rest if the URDF has none [Nm] or [N]
DEFAULT_HOLDING_EFFORT = 1000.0


class SoundUrdf(NamedTuple):
    """URDF of a robot, corrected for physics engines, with its convex meshes and the list of corrections."""

    text: str
    """The URDF as text; its collision meshes are named as in `hulls`."""
    hulls: Mapping[str, HullMesh]
    repairs: Sequence[Repair]
    """Differences from the robot's files."""


def sound_urdf(robot: RobotFile) -> SoundUrdf:
    """Return the URDF of a robot, corrected for physics engines.

    Masses and inertia are physically possible, wheels are round and have a torque limit, and collision meshes
    are convex. If the robot's file lets the base tilt, the base is mounted on a chassis with a suspension.

    Raises:
        ValueError: a mesh cannot be read, or encloses no volume.
    """
    text, repairs = repaired(robot.urdf_text())
    wheels = driven_wheels(item.name for item in joints_of(text)).all
    text = with_wheel_efforts(text, wheels, robot.drive.wheel_radius_m)
    text = with_round_wheels(text, wheels, robot.drive.tread_m)
    if robot.errors.lean_mrad_per_m > 0.0:
        links = link_names(text)
        rolling = (*driven_wheels(links).all, *casters(links))
        text, _ = repaired(sprung(text, robot.errors.lean_pivot_m, rolling))
    on_floor = [name for name in link_names(text) if name.endswith("wheel") or "caster" in name]
    hulls = with_hulls(text, floor_T_body_links(text, on_floor))
    low = f"its mesh reaches down to the floor; cut off {1e3 * FLOOR_CLEARANCE_M:.0f} mm above it"
    return SoundUrdf(hulls.text, hulls.hulls, [*repairs, *(Repair(link, low) for link in hulls.cut)])


def casters(links: Iterable[str]) -> list[str]:
    """Return those link names that contain `caster`: casters slide on the floor instead of rolling."""
    return [name for name in links if "caster" in name]


def held_still(robot: RobotFile) -> dict[str, tuple[float, float]]:
    """Return the joints, except continuous ones, that have no drive in the robot's file, such as a head's.

    Returns:
        By name of the joint: the position of the joint in the robot's kinematic model, in [rad] or [m], and
        the effort that holds the joint there, in [Nm] or [N].
    """
    leaders = joint_leaders(robot.urdf_text())
    moved: Collection[str] = {*(robot.arm.joints if robot.arm else ()), *MOVED_JOINTS, *ROCKER_JOINTS}
    found = {}
    for joint in joints_of(robot.urdf_text()):
        leader, _, offset = leaders.get(joint.name, (joint.name, 1.0, 0.0))
        if leader not in moved and joint.kind != "continuous":
            found[joint.name] = (offset, DEFAULT_HOLDING_EFFORT if joint.effort <= 0.0 else joint.effort)
    return found
