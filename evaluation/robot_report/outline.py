"""Outline of a robot as far as its URDF shows it: wheels, arm, fingers, sensor frames."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.evaluation.robot_report.masses import corners_of
from handcart.robotics.kinematics.shapes import Shape, Sphere
from handcart.robotics.kinematics.urdf_contents import JointFacts, bodies_of

from .link_tree import LinkTree
from .sensor_frames import SensorFrame, sensor_frames

MIN_AXLE_Y = 0.9  # y component of a wheel's axis
_WHEEL = re.compile(r"wheel", re.IGNORECASE)
_SIDEWAYS = re.compile(r"mecanum|omni[_-]?(wheel|drive|direct)|swerve", re.IGNORECASE)
_IDLE = re.compile(r"caster|castor|steer|swivel|rotation", re.IGNORECASE)
_FINGER = re.compile(r"finger|gripper|jaw|knuckle|thumb", re.IGNORECASE)
_FLOOR = 0.01  # [m] that a base frame may be above the floor
_TOOLS = re.compile(r"tool|tcp|grasp|hand|gripper|ee_|_ee|end_effector", re.IGNORECASE)


@dataclass(frozen=True)
class Wheels:
    """Driven wheels on the two sides of a base, with their tread and radius, as guessed from a URDF."""

    left: tuple[str, ...]
    """Names of the joints."""
    right: tuple[str, ...]
    tread: float
    """Distance between the sides, in [m]."""
    radius: float | None
    """Radius of a wheel, in [m]; None: the wheels have no collision bodies."""
    wheelbase: float = 0.0
    """Distance between the foremost and the rearmost of them, in [m]."""
    drives_sideways: bool = False
    """True if a name in the URDF says that they are mecanum, omni or swerve wheels."""


@dataclass(frozen=True)
class Outline:
    """Main parts of a robot (base, wheels, arm, hand, fingers and sensors), guessed from its URDF."""

    root: str
    """The root link, or a link fixed to it that is on the floor."""
    height: float | None
    """Height of `root` above the floor, computed from the wheels, in [m]; None: unknown."""
    wheels: Wheels | None
    arm: tuple[str, ...]
    """Joints of the longest chain, in order from the root; empty if only wheels move."""
    hand: str
    """Link at the arm's end."""
    fingers: tuple[str, str] | None
    """The two prismatic joints mounted on the link that the arm's last joint moves."""
    turning_fingers: tuple[str, ...]
    """Revolute joints of fingers or a hand mounted on the same link, if it has not two prismatic ones."""
    sensors: Mapping[str, SensorFrame]
    """Best candidate for each sensor frame, by its name in a robot's file."""
    chains: Sequence[tuple[str, ...]]
    """All chains, the longest first."""

    @property
    def frames(self) -> dict[str, str]:
        """Name of the URDF link that most probably is the frame of each sensor, by the sensor's name in a
        robot's file.
        """
        return {role: found.link for role, found in self.sensors.items()}


def outline_of(urdf_text: str) -> Outline:
    """Guess the main parts of a robot from its URDF; raise ValueError if the text is not a valid URDF."""
    tree = LinkTree(urdf_text)
    wheels = _wheels(tree, bodies_of(urdf_text), bool(_SIDEWAYS.search(urdf_text)))
    driving = set() if wheels is None else {*wheels.left, *wheels.right}
    chains = _chains(tree, driving)
    arm = chains[0] if chains else ()
    last = tree.child[arm[-1]] if arm else tree.root
    fingers = _fingers(tree, last)
    hand = _hand(tree, last, fingers)
    root, height = _base(tree, wheels)
    return Outline(
        root,
        height,
        wheels,
        arm,
        hand,
        fingers,
        _turning_fingers(tree, last) if arm and fingers is None else (),
        sensor_frames(tree, root, hand if arm else None),
        chains,
    )


def _base(tree: LinkTree, wheels: Wheels | None) -> tuple[str, float | None]:
    """Return the link on the floor, out of the root and links fixed to it, and its height above the floor."""
    if wheels is None or wheels.radius is None:
        return tree.root, None
    floor = min(float(tree.pose[tree.child[item]][2, 3]) for item in wheels.left) - wheels.radius
    heights = {link: float(tree.pose[link][2, 3]) - floor for link in tree.carried(tree.root)}
    if abs(heights[tree.root]) < _FLOOR:
        return tree.root, heights[tree.root]
    level = [link for link in heights if _is_base_frame(tree, link) and abs(heights[link]) < _FLOOR]
    base = min(level, key=lambda link: abs(heights[link]), default=tree.root)
    return base, heights[base]


def _is_base_frame(tree: LinkTree, link: str) -> bool:
    """Return whether a link has the root's orientation and is on the root's axis."""
    pose = tree.pose[link]
    return bool(np.allclose(pose[:3, :3], np.eye(3), atol=1e-3) and np.abs(pose[:2, 3]).max() < _FLOOR)


def _wheels(tree: LinkTree, bodies: Sequence[Shape], sideways: bool) -> Wheels | None:
    """Return wheels with known names, otherwise the outermost joints named "wheel" on both sides; None
    without any.
    """
    known = driven_wheels(tree.moving)
    if known.left and known.right:
        left, right = known.left, known.right
    else:
        rolls = [joint for joint in tree.moving.values() if _rolls(tree, joint)]
        out = {roll.name: float(tree.pose[roll.child][1, 3]) for roll in rolls}
        most = max((abs(y) for y in out.values()), default=0.0)
        far = {name: y for name, y in out.items() if abs(y) > 0.9 * most and most > 0.0}
        left = tuple(sorted(name for name, y in far.items() if y > 0.0))
        right = tuple(sorted(name for name, y in far.items() if y < 0.0))
    if not left or not right:
        return None
    y_left, y_right = (np.mean([tree.pose[tree.child[n]][1, 3] for n in side]) for side in (left, right))
    radius = _radius([body for body in bodies if body.name == tree.child[left[0]]])
    along = [float(tree.pose[tree.child[name]][0, 3]) for name in (*left, *right)]
    return Wheels(left, right, float(abs(y_left - y_right)), radius, max(along) - min(along), sideways)


def _rolls(tree: LinkTree, joint: JointFacts) -> bool:
    name = f"{joint.name} {joint.child}"
    if joint.kind == "prismatic" or not _WHEEL.search(name) or _IDLE.search(name):
        return False
    return abs(float((tree.pose[joint.child][:3, :3] @ tree.axis[joint.name])[1])) > MIN_AXLE_Y


def _radius(bodies: Sequence[Shape]) -> float | None:
    """Return the radius of a wheel: half of its second largest extent, which is rarely its width."""
    if not bodies:
        return None
    if isinstance(bodies[0], Sphere):
        return bodies[0].radius
    corners = np.vstack([corners_of(body) for body in bodies])
    return float(np.sort(np.ptp(corners, axis=0))[1]) / 2


def _chains(tree: LinkTree, driving: set[str]) -> list[tuple[str, ...]]:
    """Return chains of joints without wheels and without fingers at their ends, the longest first."""
    ends = [link for link in tree.links if not tree.moved_from(link)]
    found = []
    for end in ends:
        chain = tree.chain(end)
        if any(joint in driving or _WHEEL.search(joint) for joint in chain):
            continue
        found.append(tuple(_without_fingers(tree, chain)))
    longest = sorted({chain for chain in found if chain}, key=lambda chain: (-len(chain), chain))
    return [
        chain for n, chain in enumerate(longest) if all(chain != item[: len(chain)] for item in longest[:n])
    ]


def _without_fingers(tree: LinkTree, chain: Sequence[str]) -> Sequence[str]:
    """Return a chain of joints without fingers at its end.

    It ends at the body from which several joints branch, if that body is in the second half of the chain.
    """
    forks = (number for number, joint in enumerate(chain) if len(_beside(tree, joint)) > 1)
    return chain[: next((number for number in forks if 2 * number >= len(chain)), len(chain))]


def _beside(tree: LinkTree, joint: str) -> list[str]:
    """Return the joint and those mounted on the same body, such as the fingers of one hand."""
    link = tree.parent[joint]
    while link in tree.above and tree.above[link] not in tree.moving:
        link = tree.parent[tree.above[link]]
    return tree.moved_from(link)


def _hand(tree: LinkTree, last: str, fingers: tuple[str, str] | None) -> str:
    """Return the tool frame on an arm's last link: with fingers, one on their own body comes first.

    An arm's own flange frames, such as `ee_link` and `tool0` of a UR5, do not know which gripper is mounted.
    """
    carried = tree.carried(last)
    if "hand" in carried:
        return "hand"
    if fingers is not None:
        own = tree.carried(tree.parent[fingers[0]])[1:]
        if tools := [link for link in own if _TOOLS.search(link)]:
            return tools[0]
    return next((link for link in carried if _TOOLS.search(link)), last)


def _fingers(tree: LinkTree, last: str) -> tuple[str, str] | None:
    sliding = [text for text in tree.moved_from(last) if tree.moving[text].kind == "prismatic"]
    if len(sliding) != 2:
        return None
    left = [text for text in sliding if re.search(r"left|_l_|^l_", text)]
    first = left[0] if len(left) == 1 else sliding[0]
    return first, next(text for text in sliding if text != first)


def _turning_fingers(tree: LinkTree, last: str) -> tuple[str, ...]:
    """Return revolute joints on a hand: those with a finger's name, or several."""
    found = [text for text in tree.moved_from(last) if tree.moving[text].kind != "prismatic"]
    called = any(_FINGER.search(f"{text} {tree.child[text]}") for text in found)
    return tuple(found) if len(found) > 1 or called else ()
