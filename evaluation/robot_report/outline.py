"""What a robot's file would say of a URDF, as far as the URDF tells it: wheels, an arm, fingers, frames."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.kinematics.shapes import Shape, Sphere
from handcart.robotics.kinematics.urdf_contents import JointFacts, bodies_of, joints_of
from handcart.robotics.kinematics.urdf_frames import link_poses
from handcart.robotics.kinematics.urdf_reading import known_urdf
from handcart.robotics.kinematics.urdf_tree import joint_leaders

from .masses import corners_of

ACROSS = 0.9  # of a wheel's axis: least part along y
_WHEEL = re.compile(r"wheel", re.IGNORECASE)
_IDLE = re.compile(r"caster|castor|steer|swivel|rotation", re.IGNORECASE)
_FRAMES = {
    "range_sensor": re.compile(r"laser|lidar|scan|rplidar|hokuyo|sick", re.IGNORECASE),
    "camera": re.compile(r"optical_frame|camera", re.IGNORECASE),
    "imu": re.compile(r"imu", re.IGNORECASE),
    "gps": re.compile(r"gps|gnss", re.IGNORECASE),
}
_TOOLS = re.compile(r"tool|tcp|grasp|hand|gripper|ee_|_ee|end_effector", re.IGNORECASE)


@dataclass(frozen=True)
class Wheels:
    """Two sides that drive."""

    left: tuple[str, ...]
    """Joints."""
    right: tuple[str, ...]
    tread: float
    """Distance between them, in [m]."""
    radius: float | None
    """[m]; None: the wheels have no collision bodies."""


@dataclass(frozen=True)
class Outline:
    """A robot as its URDF lets one guess it."""

    root: str
    """The link that carries all."""
    wheels: Wheels | None
    arm: tuple[str, ...]
    """Joints of the longest chain, from the root on; empty: nothing moves but wheels."""
    hand: str
    """The link at its end."""
    fingers: tuple[str, str] | None
    """Two joints that slide, on what the chain's last joint moves."""
    frames: Mapping[str, str]
    """By the name that a robot's file expects: a link that may stand for it."""
    chains: Sequence[tuple[str, ...]]
    """All chains, the longest first."""


def outline_of(urdf_text: str) -> Outline:
    """Guess; raises ValueError where the text is no sound URDF."""
    tree = _Tree(urdf_text)
    wheels = _wheels(tree, bodies_of(urdf_text))
    driving = set() if wheels is None else {*wheels.left, *wheels.right}
    chains = _chains(tree, driving)
    arm = chains[0] if chains else ()
    last = tree.child[arm[-1]] if arm else tree.root
    frames = {role: found for role in _FRAMES if (found := _frame(tree, role)) is not None}
    return Outline(tree.root, wheels, arm, _hand(tree, last), _fingers(tree, last), frames, chains)


class _Tree:
    """Links and joints, and where they stand with all joints at zero."""

    def __init__(self, urdf_text: str) -> None:
        robot = known_urdf(urdf_text)
        joints = robot.findall("joint")
        self.child = {each.get("name", ""): _end(each, "child") for each in joints}
        self.parent = {each.get("name", ""): _end(each, "parent") for each in joints}
        self.above = {self.child[name]: name for name in self.child}
        self.links = [each.get("name", "") for each in robot.findall("link")]
        self.root = next(name for name in self.links if name not in self.above)
        self.moving = {each.name: each for each in joints_of(urdf_text)}
        self.led = joint_leaders(urdf_text)
        self.pose = link_poses(urdf_text)
        self.axis = {each.get("name", ""): _axis(each.find("axis")) for each in joints}

    def chain(self, link: str) -> list[str]:
        """The joints that move a link, from the root on; those that follow another are left out."""
        found = []
        while link in self.above:
            joint = self.above[link]
            if joint in self.moving and joint not in self.led:
                found.append(joint)
            link = self.parent[joint]
        return found[::-1]

    def carried(self, link: str) -> list[str]:
        """The link and those fixed onto it, in the file's order of joints."""
        found = [link]
        for each in found:
            found += [self.child[j] for j in self.child if self.parent[j] == each and j not in self.moving]
        return found

    def moved_from(self, link: str) -> list[str]:
        """The joints that stand on a link or on what is fixed onto it."""
        body = set(self.carried(link))
        return [joint for joint in self.moving if self.parent[joint] in body]


def _wheels(tree: _Tree, bodies: Sequence[Shape]) -> Wheels | None:
    """Those of our names; else what is called a wheel and rolls ahead, the farthest out on both sides."""
    known = driven_wheels(tree.moving)
    if known.left and known.right:
        left, right = known.left, known.right
    else:
        rolls = [joint for joint in tree.moving.values() if _rolls(tree, joint)]
        out = {each.name: float(tree.pose[each.child][1, 3]) for each in rolls}
        most = max((abs(y) for y in out.values()), default=0.0)
        far = {name: y for name, y in out.items() if abs(y) > 0.9 * most and most > 0.0}
        left = tuple(sorted(name for name, y in far.items() if y > 0.0))
        right = tuple(sorted(name for name, y in far.items() if y < 0.0))
    if not left or not right:
        return None
    y_left, y_right = (np.mean([tree.pose[tree.child[n]][1, 3] for n in side]) for side in (left, right))
    radius = _radius([each for each in bodies if each.name == tree.child[left[0]]])
    return Wheels(left, right, float(abs(y_left - y_right)), radius)


def _rolls(tree: _Tree, joint: JointFacts) -> bool:
    name = f"{joint.name} {joint.child}"
    if joint.kind == "prismatic" or not _WHEEL.search(name) or _IDLE.search(name):
        return False
    return abs(float((tree.pose[joint.child][:3, :3] @ tree.axis[joint.name])[1])) > ACROSS


def _radius(bodies: Sequence[Shape]) -> float | None:
    """Of a wheel: half of its second largest extent, which its tread is seldom."""
    if not bodies:
        return None
    if isinstance(bodies[0], Sphere):
        return bodies[0].radius
    corners = np.vstack([corners_of(each) for each in bodies])
    return float(np.sort(np.ptp(corners, axis=0))[1]) / 2


def _chains(tree: _Tree, driving: set[str]) -> list[tuple[str, ...]]:
    """Chains of joints without wheels, without fingers at their ends; the longest first."""
    ends = [link for link in tree.links if not tree.moved_from(link)]
    found = []
    for end in ends:
        chain = tree.chain(end)
        if any(joint in driving or _WHEEL.search(joint) for joint in chain):
            continue
        found.append(tuple(_without_fingers(tree, chain)))
    longest = sorted({chain for chain in found if chain}, key=lambda chain: (-len(chain), chain))
    return [
        chain for n, chain in enumerate(longest) if all(chain != each[: len(chain)] for each in longest[:n])
    ]


def _without_fingers(tree: _Tree, chain: Sequence[str]) -> Sequence[str]:
    """A chain to where several joints leave one body, if that is in its second half."""
    forks = (number for number, joint in enumerate(chain) if len(_beside(tree, joint)) > 1)
    return chain[: next((number for number in forks if 2 * number >= len(chain)), len(chain))]


def _beside(tree: _Tree, joint: str) -> list[str]:
    """The joint and those that move from the same body: fingers of one hand."""
    link = tree.parent[joint]
    while link in tree.above and tree.above[link] not in tree.moving:
        link = tree.parent[tree.above[link]]
    return tree.moved_from(link)


def _hand(tree: _Tree, last: str) -> str:
    carried = tree.carried(last)
    if "hand" in carried:
        return "hand"
    return next((link for link in carried if _TOOLS.search(link)), last)


def _fingers(tree: _Tree, last: str) -> tuple[str, str] | None:
    sliding = [each for each in tree.moved_from(last) if tree.moving[each].kind == "prismatic"]
    if len(sliding) != 2:
        return None
    left = [each for each in sliding if re.search(r"left|_l_|^l_", each)]
    first = left[0] if len(left) == 1 else sliding[0]
    return first, next(each for each in sliding if each != first)


def _frame(tree: _Tree, role: str) -> str | None:
    if role in tree.links:
        return role
    return next((link for link in tree.links if _FRAMES[role].search(link)), None)


def _end(joint: object, tag: str) -> str:
    found = joint.find(tag)  # type: ignore[attr-defined]
    return "" if found is None else str(found.get("link", ""))


def _axis(element: object) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    words = "1 0 0" if element is None else element.get("xyz", "1 0 0")  # type: ignore[attr-defined]
    axis = np.array([float(word) for word in words.split()])
    return axis / max(1e-9, float(np.linalg.norm(axis)))
