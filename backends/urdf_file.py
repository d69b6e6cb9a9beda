"""Reading a URDF: within limits, its numbers finite, each fault at its line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from files.xml_file import XmlTag, read_xml_text

LARGEST = 1e18
"""In any unit: makers write 1e16 for 'no limit'."""
_NUMBERS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": dict.fromkeys(("damping", "friction"), 1),
    "mimic": dict.fromkeys(("multiplier", "offset"), 1),
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "box": {"size": 3},
    "sphere": {"radius": 1},
    "cylinder": dict.fromkeys(("radius", "length"), 1),
    "capsule": dict.fromkeys(("radius", "length"), 1),
    "mesh": {"scale": 3},
    "color": {"rgba": 4},
}
"""How many numbers stand in each attribute, after http://wiki.ros.org/urdf/XML."""


def read_urdf_file(path: Path) -> str:
    """The text of a robot's URDF.

    Raises:
        FileError: it can't be read, or is no XML within the limits of `read_xml_text`; its root is another
            than <robot>; or what should be a number in a link, joint or material is none.
    """
    return read_xml_text(path, _wrong)


def _wrong(tag: XmlTag) -> Iterator[str]:
    if not tag.parents and tag.name != "robot":
        yield f"the URDF's root is <{tag.name}>; allowed: <robot>"
    part = tag.parents[1] if len(tag.parents) > 1 else None  # of the robot
    if part is None or part.name not in ("link", "joint", "material"):
        return
    for key, count in _NUMBERS.get(tag.name, {}).items():
        words = tag.attributes.get(key, "").split()
        if key in tag.attributes and not (len(words) == count and all(map(_is_number, words))):
            allowed = "a finite number" if count == 1 else f"{count} finite numbers"
            told = f"{tag.name} {key} is {tag.attributes[key][:60]!r}"
            yield f"{part.name} {part.attributes.get('name', '')!r}: {told}; allowed: {allowed}"


def _is_number(word: str) -> bool:
    try:
        value = float(word)
    except ValueError:
        return False
    # Python takes underscores, which are no part of a number in XML.
    return math.isfinite(value) and abs(value) <= LARGEST and "_" not in word
