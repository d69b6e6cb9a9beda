"""Putting one robot together from several URDFs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from handcart.robotics.kinematics.urdf_reading import read_urdf

_REFERENCES = (("parent", "link"), ("child", "link"), ("mimic", "joint"))


class Part(NamedTuple):
    """A URDF, such as that of a tool, and the place where it is to be fixed onto a link of another URDF."""

    urdf_text: str
    onto: str
    """Link of the other URDF that carries the part."""
    xyz: tuple[float, float, float]
    """Position of the part's root link in the link `onto`, in [m]."""
    rpy: tuple[float, float, float]
    """Roll, pitch and yaw of the part's root link in `onto`, in [rad], as in a URDF."""
    prefix: str = ""
    """Prefix of the names of the part's links and joints."""


def with_part(urdf_text: str, part: Part) -> str:
    """Return a URDF with a part fixed onto one of its links. Of the part, only links, joints and materials
    are copied.

    Raises:
        ValueError: one of the two URDFs can't be read, the link that should carry the part is missing, or a
            link or joint has the same name in both URDFs.
    """
    robot, added = read_urdf(urdf_text), read_urdf(part.urdf_text)
    links = _names(robot, "link")
    if part.onto not in links:
        raise ValueError(f"unknown link {part.onto!r} to put it onto; allowed: {', '.join(links)}")
    _prefix(added, part.prefix)
    root = root_link(added)
    for kind in ("link", "joint"):
        if both := sorted({*_names(robot, kind)} & {*_names(added, kind)}):
            raise ValueError(f"both have a {kind} {both[0]!r}; allowed: a prefix that distinguishes them")
    known = _names(robot, "material")
    robot.extend(
        item
        for item in added
        if item.tag in ("link", "joint") or (item.tag == "material" and item.get("name") not in known)
    )
    robot.append(_mount(part, root))
    return ElementTree.tostring(robot, encoding="unicode")


def with_mesh_files(
    urdf_text: str, found: Callable[[str], str], unit_m: Callable[[str], float] = lambda _: 1.0
) -> str:
    """Return a URDF in which mesh files have other names, and meshes are scaled from their files' units to
    metres.

    Args:
        urdf_text: the URDF.
        found: returns the new name of a mesh file, given the one in the URDF.
        unit_m: returns the unit of a mesh file's coordinates, in [m], given the file's name in the URDF.
    """
    robot = read_urdf(urdf_text)
    for mesh in robot.iter("mesh"):
        name = mesh.get("filename", "")
        mesh.set("filename", found(name))
        if (unit := unit_m(name)) != 1.0:
            _multiply_scale(mesh, unit)
    return ElementTree.tostring(robot, encoding="unicode")


def _multiply_scale(mesh: ElementTree.Element, factor: float) -> None:
    """Multiply the scale of a mesh; keep a scale of a visual mesh that is not a list of numbers."""
    try:
        scales = [factor * float(word) for word in mesh.get("scale", "1 1 1").split()]
    except ValueError:
        return
    mesh.set("scale", " ".join(map(repr, scales)))


Names = dict[str, str]


def with_names(
    urdf_text: str, links: Sequence[tuple[str, str]], joints: Sequence[tuple[str, str]]
) -> tuple[str, Names, Names]:
    """Return a URDF with some links and joints renamed, and maps from the old names to the new ones.

    The link that a renamed joint moves gets the joint's new name as well. If a link is given a second new
    name, a frame with that name is fixed to it. If a new name is in use already, the element that had it gets
    an underscore appended.

    Args:
        urdf_text: the URDF with all these links and joints.
        links: old and new names of links.
        joints: old and new names of joints.

    Raises:
        ValueError: the text is not a URDF.
    """
    robot = read_urdf(urdf_text)
    now: dict[str, Names] = {"link": {}, "joint": {}}
    for old, new in joints:
        child = robot.find(f"joint[@name='{now['joint'].get(old, old)}']/child")
        moved = "" if child is None else child.get("link", "")
        _rename(robot, "joint", old, new, now["joint"])
        _rename(
            robot, "link", next((a for a, b in now["link"].items() if b == moved), moved), new, now["link"]
        )
    for old, new in links:
        if old in now["link"]:
            robot.append(_frame(robot, now["link"][old], new))
        else:
            _rename(robot, "link", old, new, now["link"])
    return ElementTree.tostring(robot, encoding="unicode"), now["link"], now["joint"]


def _rename(robot: ElementTree.Element, kind: str, old: str, new: str, now: Names) -> None:
    names = _names(robot, kind)
    if new in names and old != new:
        spare = f"{new}_"
        while spare in names:
            spare += "_"
        _put_name(robot, kind, new, spare)
        now[new] = spare
    _put_name(robot, kind, now.get(old, old), new)
    now[old] = new


def _put_name(robot: ElementTree.Element, kind: str, old: str, new: str) -> None:
    for match in robot.findall(kind):
        if match.get("name") == old:
            match.set("name", new)
    for tag, key in _REFERENCES:
        for match in robot.findall(f"joint/{tag}"):
            if key == kind and match.get(key) == old:
                match.set(key, new)


def _frame(robot: ElementTree.Element, onto: str, name: str) -> ElementTree.Element:
    """Return a joint that fixes a new link without mass onto another; the link is added."""
    ElementTree.SubElement(robot, "link", {"name": name})
    return _fixed(f"{name}_frame", onto, name, ("0 0 0", "0 0 0"))


def root_link(robot: ElementTree.Element) -> str:
    """Return the name of a URDF's root link, which is the only link that no joint moves.

    Raises:
        ValueError: the URDF has no such link, or several.
    """
    children = {child.get("link") for child in robot.findall("joint/child")}
    roots = [name for name in _names(robot, "link") if name not in children]
    if len(roots) != 1:
        raise ValueError(f"a URDF has one root link; this one has {len(roots)}: {', '.join(roots)}")
    return roots[0]


def _names(robot: ElementTree.Element, kind: str) -> list[str]:
    return [match.get("name", "") for match in robot.findall(kind)]


def _prefix(robot: ElementTree.Element, prefix: str) -> None:
    for kind in ("link", "joint"):
        for match in robot.findall(kind):
            match.set("name", prefix + match.get("name", ""))
    for tag, key in _REFERENCES:
        for match in robot.findall(f"joint/{tag}"):
            match.set(key, prefix + match.get(key, ""))


def _mount(part: Part, root: str) -> ElementTree.Element:
    xyz, rpy = (" ".join(repr(number) for number in numbers) for numbers in (part.xyz, part.rpy))
    return _fixed(f"{root}_on_{part.onto}", part.onto, root, (xyz, rpy))


def _fixed(name: str, parent: str, child: str, origin: tuple[str, str]) -> ElementTree.Element:
    joint = ElementTree.Element("joint", {"name": name, "type": "fixed"})
    ElementTree.SubElement(joint, "parent", {"link": parent})
    ElementTree.SubElement(joint, "child", {"link": child})
    ElementTree.SubElement(joint, "origin", {"xyz": origin[0], "rpy": origin[1]})
    return joint
