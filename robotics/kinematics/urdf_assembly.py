"""Putting one robot together from several URDFs."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple
from xml.etree import ElementTree

_REFERENCES = (("parent", "link"), ("child", "link"), ("mimic", "joint"))


class Part(NamedTuple):
    """A URDF that is fixed onto a link of what is there already."""

    urdf_text: str
    onto: str
    """The link that carries it."""
    xyz: tuple[float, float, float]
    """Where the part's root link stands in that link, in [m]."""
    rpy: tuple[float, float, float]
    """Its roll, pitch and yaw there, in [rad], as in a URDF."""
    prefix: str = ""
    """Put before the names of its links and joints."""


def read_urdf(text: str) -> ElementTree.Element:
    """The URDF's root element.

    Raises:
        ValueError: it is not well-formed XML, or no robot.
    """
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"the URDF is not well-formed: {error}") from error
    if robot.tag != "robot":
        raise ValueError(f"the URDF's root is <{robot.tag}>; allowed: <robot>")
    return robot


def link_names(urdf_text: str) -> list[str]:
    """The names of all links; raises ValueError where the text is no URDF."""
    return _names(read_urdf(urdf_text), "link")


def with_part(urdf_text: str, part: Part) -> str:
    """A URDF with another one fixed onto a link of it. Only links, joints and materials are taken over.

    Raises:
        ValueError: one of the two can't be read, the link isn't there, or both have a name.
    """
    robot, added = read_urdf(urdf_text), read_urdf(part.urdf_text)
    links = _names(robot, "link")
    if part.onto not in links:
        raise ValueError(f"there is no link {part.onto!r} to put it onto; allowed: {', '.join(links)}")
    _prefix(added, part.prefix)
    root = root_link(added)
    for kind in ("link", "joint"):
        if both := sorted({*_names(robot, kind)} & {*_names(added, kind)}):
            raise ValueError(f"both have a {kind} {both[0]!r}; allowed: a prefix that tells them apart")
    known = _names(robot, "material")
    robot.extend(
        each
        for each in added
        if each.tag in ("link", "joint") or (each.tag == "material" and each.get("name") not in known)
    )
    robot.append(_mount(part, root))
    return ElementTree.tostring(robot, encoding="unicode")


def with_mesh_files(urdf_text: str, found: Callable[[str], str]) -> str:
    """A URDF whose meshes are named by what `found` gives for the names that stand there."""
    robot = read_urdf(urdf_text)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", found(mesh.get("filename", "")))
    return ElementTree.tostring(robot, encoding="unicode")


def root_link(robot: ElementTree.Element) -> str:
    """The link that no joint moves.

    Raises:
        ValueError: there are none or several.
    """
    children = {child.get("link") for child in robot.findall("joint/child")}
    roots = [name for name in _names(robot, "link") if name not in children]
    if len(roots) != 1:
        raise ValueError(f"a URDF has one root link; this one has {len(roots)}: {', '.join(roots)}")
    return roots[0]


def _names(robot: ElementTree.Element, kind: str) -> list[str]:
    return [each.get("name", "") for each in robot.findall(kind)]


def _prefix(robot: ElementTree.Element, prefix: str) -> None:
    for kind in ("link", "joint"):
        for each in robot.findall(kind):
            each.set("name", prefix + each.get("name", ""))
    for tag, key in _REFERENCES:
        for each in robot.findall(f"joint/{tag}"):
            each.set(key, prefix + each.get(key, ""))


def _mount(part: Part, root: str) -> ElementTree.Element:
    joint = ElementTree.Element("joint", {"name": f"{root}_on_{part.onto}", "type": "fixed"})
    ElementTree.SubElement(joint, "parent", {"link": part.onto})
    ElementTree.SubElement(joint, "child", {"link": root})
    xyz, rpy = (" ".join(repr(number) for number in numbers) for numbers in (part.xyz, part.rpy))
    ElementTree.SubElement(joint, "origin", {"xyz": xyz, "rpy": rpy})
    return joint
