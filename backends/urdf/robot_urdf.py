"""The URDF of a complete robot, assembled from its parts, with the source place of each element."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.files.suggest import suggest
from handcart.robotics.kinematics.srdf import disabled_pairs
from handcart.robotics.kinematics.urdf_assembly import with_names, with_part
from handcart.robotics.kinematics.urdf_contents import joints_of
from handcart.robotics.kinematics.urdf_reading import UrdfFaults
from handcart.robotics.kinematics.urdf_tree import FollowingJoint, with_still_joints

from .driven_wheels import driven_wheels
from .robot_parts import KeyPath, PartSpec, UrdfError, read_part, read_srdf

Pair = tuple[str, str]
FINGER_JOINTS = ("left_finger", "right_finger")


class SourcePlace(NamedTuple):
    """Place of a link or joint in the URDF file that defines it; line and column count from 1."""

    file: str
    line: int
    column: int

    def finding(self, message: str) -> Finding:
        """Return a finding with a message, at this place in the URDF file."""
        return Finding(self.file, self.line, self.column, message)


@dataclass(frozen=True)
class RobotUrdf:
    """URDF of a robot, composed of its parts' URDFs, with the file and line of each link and joint."""

    text: str
    """The URDF; meshes named by absolute paths, links and joints as the robot's file maps them."""
    places: Mapping[tuple[str, str], SourcePlace]
    """Place of each element in its maker's file, by ("link" or "joint", name)."""
    allowed: frozenset[Pair] = frozenset()
    """Pairs of links that may touch each other, by SRDF files and by the robot's file."""
    disabled: int = 0
    """Number of the pairs in `allowed` that come from SRDF files."""
    doubts: Sequence[Finding] = field(default_factory=tuple)
    """Faults in the URDFs that do not prevent their use."""

    def finding(self, kind: str, name: str, message: str) -> Finding | None:
        """Return a finding at the place of a link or joint in the URDF file that defines it.

        None if the link or joint comes from no URDF file.

        Args:
            kind: "link" or "joint".
            name: name of the link or joint in the robot's complete URDF.
            message: message of the finding, what is wrong and what is allowed.
        """
        place = self.places.get((kind, name))
        return None if place is None else place.finding(f"{kind} {name!r}: {message}")

    def remark(self, kind: str, name: str, message: str) -> str:
        """Return a remark about a link or joint as text, preceded by its place in a URDF if known.

        Args:
            kind: "link" or "joint".
            name: name of the link or joint in the robot's complete URDF.
            message: text of the remark.
        """
        return str(self.finding(kind, name, message) or f"{kind} {name!r}: {message}")


def robot_urdf(
    specs: Sequence[PartSpec],
    folder: Path,
    roles: Mapping[Any, str],
    joints: Sequence[tuple[KeyPath, str, str]],
    allowed: Sequence[Pair],
    still: Mapping[str, float] | None = None,
) -> RobotUrdf:
    """Compose the URDF of a robot from the URDFs of its parts, as the robot's file describes.

    Args:
        specs: the robot's own URDF, then its further parts.
        folder: folder of the robot's file.
        roles: roles of links, such as the robot's hand; the value is the link's name in the URDFs.
        joints: joints that the file names: key path, name in the URDFs, and the expected name.
        allowed: pairs of links that may touch, by the robot's file.
        still: joints that are never moved, and their positions in [deg] or [mm], by their names in the URDF.

    Raises:
        FileError: a URDF or SRDF is faulty.
        UrdfError: a URDF is missing, cannot be mounted at its link, or lacks a mapped link or joint.
    """
    text, pairs = "", []
    places: dict[tuple[str, str], SourcePlace] = {}
    doubts: list[Finding] = []
    for number, spec in enumerate(specs):
        try:
            part = read_part(spec.urdf, folder, spec.without)
            text = with_part(text, spec.part(part.text)) if number else part.text
            pairs += _pairs(spec, folder)
        except FileError:  # has the URDF's own lines
            raise
        except UrdfError as error:
            raise UrdfError(str(error), _key(number, error.key)) from error
        except ValueError as error:
            raise UrdfError(str(error), _key(number, None)) from error
        doubts += part.doubts
        for (kind, name), (line, column) in part.places.items():
            places[kind, spec.prefix + name] = SourcePlace(part.file, line, column)
    text = _with_still(text, still or {})
    links: dict[str, str] = {}
    joints_now: dict[str, str] = {}
    named = _mapped(roles, joints, places)
    named[1].extend(_with_other_links(text, named[1]))
    if any(named):
        text, links, joints_now = with_names(text, *named)
    now = {"link": links, "joint": joints_now}
    stated = [(links.get(a, a), links.get(b, b)) for a, b in (*pairs, *allowed)]
    return RobotUrdf(
        text,
        {(kind, now[kind].get(name, name)): place for (kind, name), place in places.items()},
        frozenset((min(pair), max(pair)) for pair in stated),
        len(pairs),
        doubts,
    )


def _key(number: int, key: KeyPath | None) -> KeyPath:
    """Return the key of the robot's file that names its own URDF (number 0) or that of a part."""
    last = key or ("urdf",)
    return last if number == 0 else ("parts", number - 1, *(key or ()))


def _with_still(text: str, still: Mapping[str, float]) -> str:
    """Return the URDF with joints fixed at positions in [deg] or [mm]."""
    if not still:
        return text
    facts = {item.name: item for item in joints_of(text)}
    positions: dict[str, float] = {}
    for name, value in still.items():
        if name not in facts:
            raise UrdfError(f"the URDF has no movable joint {name!r}{suggest(name, facts)}", ("still", name))
        joint, slides = facts[name], facts[name].kind == "prismatic"
        unit, scale = ("mm", 1e-3) if slides else ("deg", math.radians(1.0))
        positions[name] = scale * value
        low, high = joint.lower, joint.upper
        if low is not None and high is not None and not low <= positions[name] <= high:
            limits = f"{low / scale:.1f} to {high / scale:.1f} {unit}"
            raise UrdfError(f"{name!r} can't stand at {value:g} {unit}; allowed: {limits}", ("still", name))
    try:
        return with_still_joints(text, positions)
    except FollowingJoint as error:
        raise UrdfError(str(error), ("still", error.joint)) from error


def _pairs(spec: PartSpec, folder: Path) -> list[Pair]:
    if spec.srdf is None:
        return []
    try:
        pairs = disabled_pairs(read_srdf(spec.srdf, folder))
    except UrdfFaults as wrong:
        findings = [Finding(spec.srdf, fault.line, fault.column, fault.message) for fault in wrong.faults]
        raise FileError(findings) from wrong
    except FileError:
        raise
    except ValueError as error:
        raise UrdfError(str(error), ("srdf",)) from error
    return [(spec.prefix + a, spec.prefix + b) for a, b in pairs]


def _with_other_links(text: str, renamed: Sequence[Pair]) -> list[Pair]:
    """Return the joints of wheels and fingers that keep their names, but whose links are called otherwise.

    Programs look for the link of a wheel or finger by the joint's name, so those links get it.

    Args:
        text: the URDF.
        renamed: joints that the robot's file renames: name in the URDF, new name.
    """
    links = {joint.name: joint.child for joint in joints_of(text)}
    taken = {name for pair in renamed for name in pair}
    names = (*driven_wheels(links).all, *FINGER_JOINTS)
    return [(name, name) for name in names if links.get(name, name) != name and name not in taken]


def _mapped(
    roles: Mapping[str, str],
    named: Sequence[tuple[KeyPath, str, str]],
    places: Mapping[tuple[str, str], SourcePlace],
) -> tuple[list[Pair], list[Pair]]:
    """Return the links, and the joints, that the robot's file renames: (name in the URDF, new name) each."""
    links = [(key, ("links", role), role) for role, key in roles.items()]
    joints = [(joint, key, name) for key, joint, name in named]
    for kind, asked in (("link", links), ("joint", joints)):
        known = [name for item, name in places if item == kind]
        for old, key, _ in asked:
            if old not in known:
                wrong = f"the URDF has no {kind} {old!r}{suggest(old, known)}"
                raise UrdfError(wrong, key)
    by_role = [(old, str(role)) for old, _, role in links if old != role]
    return by_role, [(old, name) for old, _, name in joints if old != name]
