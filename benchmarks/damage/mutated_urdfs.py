"""URDFs with one thing broken in them, as a maker or a hurried hand might."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from xml.etree import ElementTree

Change = Callable[[ElementTree.Element, random.Random], str]
_NUMBERS = ("xyz", "rpy", "size", "radius", "length", "value", "ixx", "lower", "upper", "velocity", "effort")
_BAD_NUMBERS = ("nan", "inf", "", "1,5", "-1", "0", "1e308", "1 2", "1 2 3 4", "abc", "0 0 0", "${pi}", "1_0")
_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "ball", "", "Revolute")


def mutated(text: str, seed: int) -> tuple[str, str]:
    """Return a URDF with one change, and that in words; the same for the same seed.

    Args:
        text: a URDF that is well-formed.
        seed: of what is changed.
    """
    rng = random.Random(seed)
    if rng.random() < _RAW:
        return _cut(text, rng)
    robot = ElementTree.fromstring(text)
    for _ in range(_TRIES):
        words = rng.choice(_CHANGES)(robot, rng)
        if words:
            return ElementTree.tostring(robot, encoding="unicode"), words
    return text, "nothing"


def _cut(text: str, rng: random.Random) -> tuple[str, str]:
    at = rng.randrange(len(text))
    if rng.random() < 0.5:
        return text[:at], f"cut off at character {at}"
    return text[:at] + rng.choice("<>&\"'\x00é") + text[at + 1 :], f"character {at} is another"


def _delete(robot: ElementTree.Element, rng: random.Random) -> str:
    parent, child = _any_pair(robot, rng)
    if parent is None or child is None:
        return ""
    parent.remove(child)
    return f"<{child.tag} {child.get('name', '')}> of <{parent.tag} {parent.get('name', '')}> is gone"


def _double(robot: ElementTree.Element, rng: random.Random) -> str:
    parent, child = _any_pair(robot, rng)
    if parent is None or child is None:
        return ""
    parent.append(child)
    return f"<{child.tag} {child.get('name', '')}> stands there twice"


def _rename(robot: ElementTree.Element, rng: random.Random) -> str:
    each = _any(robot, rng, "link", "joint", "mesh")
    if each is None:
        return ""
    key = "filename" if each.tag == "mesh" else "name"
    old, new = each.get(key, ""), rng.choice(("", "other", "base", "a b", "x/../y", each.get(key, "") + "_"))
    each.set(key, new)
    return f"{each.tag} {old!r} is called {new!r}"


def _drop_attribute(robot: ElementTree.Element, rng: random.Random) -> str:
    named = [item for item in robot.iter() if item.attrib]
    if not named:
        return ""
    each = rng.choice(named)
    key = rng.choice(list(each.attrib))
    del each.attrib[key]
    return f"<{each.tag}> has no {key}"


def _break_number(robot: ElementTree.Element, rng: random.Random) -> str:
    found = [(item, key) for item in robot.iter() for key in item.attrib if key in _NUMBERS]
    if not found:
        return ""
    each, key = rng.choice(found)
    value = rng.choice(_BAD_NUMBERS)
    each.set(key, value)
    return f"{key} of <{each.tag}> is {value!r}"


def _reference(robot: ElementTree.Element, rng: random.Random) -> str:
    each = _any(robot, rng, "parent", "child")
    if each is None:
        return ""
    names = [link.get("name", "") for link in robot.findall("link")]
    new = rng.choice([*names, "nobody", ""])
    each.set("link", new)
    return f"a {each.tag} is {new!r}"


def _kind(robot: ElementTree.Element, rng: random.Random) -> str:
    joints = robot.findall("joint")
    if not joints:
        return ""
    joint, kind = rng.choice(joints), rng.choice(_KINDS)
    joint.set("type", kind)
    return f"joint {joint.get('name')!r} is of type {kind!r}"


def _mimic(robot: ElementTree.Element, rng: random.Random) -> str:
    joints = robot.findall("joint")
    if not joints:
        return ""
    joint = rng.choice(joints)
    led = rng.choice([item.get("name", "") for item in joints] + ["nobody"])
    ElementTree.SubElement(joint, "mimic", {"joint": led, "multiplier": rng.choice(("-1", "0", "1e9", "x"))})
    return f"joint {joint.get('name')!r} mimics {led!r}"


def _swap_limits(robot: ElementTree.Element, rng: random.Random) -> str:
    each = _any(robot, rng, "limit")
    if each is None:
        return ""
    lower, upper = each.get("lower", "0"), each.get("upper", "0")
    each.set("lower", upper)
    each.set("upper", rng.choice((lower, upper)))
    return "limits are the wrong way round, or equal"


def _solid(robot: ElementTree.Element, rng: random.Random) -> str:
    geometry = _any(robot, rng, "geometry")
    if geometry is None or not len(geometry):
        return ""
    geometry[0].tag = rng.choice(("box", "cylinder", "sphere", "mesh", "capsule", "cone"))
    return f"a body is a {geometry[0].tag}"


def _any(robot: ElementTree.Element, rng: random.Random, *tags: str) -> ElementTree.Element | None:
    found = [item for item in robot.iter() if item.tag in tags]
    return rng.choice(found) if found else None


def _any_pair(
    robot: ElementTree.Element, rng: random.Random
) -> tuple[ElementTree.Element | None, ElementTree.Element | None]:
    pairs = [(parent, child) for parent in robot.iter() for child in parent]
    return rng.choice(pairs) if pairs else (None, None)


def places_in(words: str, name: str) -> list[int]:
    """Return the lines of the file `name` that the output of `check` names."""
    return [int(found) for found in re.findall(rf"{re.escape(name)}:(\d+):\d+: ", words)]


_RAW = 0.1  # share of the changes that make no XML
_TRIES = 50
_CHANGES: tuple[Change, ...] = (
    _delete,
    _double,
    _rename,
    _drop_attribute,
    _break_number,
    _break_number,
    _reference,
    _kind,
    _mimic,
    _swap_limits,
    _solid,
)
