"""Corrections of a robot's URDF that physics engines need."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from handcart.robotics.kinematics.urdf_contents import INERTIA_ROUNDED, LinkFacts, joints_of, links_of

MIN_MASS_KG = 1e-6  # of a link without mass [kg], and its inertia [kg m²]
MIN_INERTIA_RATIO = 1e-6
"""Least ratio of a link's other moments of inertia to its largest one; engines reject lower ratios."""


class Repair(NamedTuple):
    """A correction of a link's mass or inertia in a URDF, with the link's name and a text on what was
    changed.
    """

    link: str
    what: str


def repaired(urdf: str) -> tuple[str, list[Repair]]:
    """Return the URDF with physically possible masses and inertia, and the corrections that affect a
    simulation.

    A link without mass gets `MIN_MASS_KG`. This correction is not listed for a link without collision shapes
    that is fixed to its parent, because it has no effect.
    """
    robot = ElementTree.fromstring(urdf)
    links = {match.get("name", ""): match for match in robot.findall("link")}
    moved = {item.child for item in joints_of(urdf)}
    done = []
    for facts in links_of(urdf):
        link = links[facts.name]
        what = _repair(link, facts, facts.name in moved or link.find("collision") is not None)
        done += [Repair(facts.name, what)] if what else []
    return ElementTree.tostring(robot, encoding="unicode"), done


def _repair(link: Element, facts: LinkFacts, matters: bool) -> str:
    if facts.mass is None or facts.mass <= 0.0:
        _make_light(link)
        has = "no mass" if facts.mass is None else f"a mass of {facts.mass:g} kg"
        return f"{has}; given {MIN_MASS_KG:g} kg and {MIN_MASS_KG:g} kg m²" if matters else ""
    small, middle, large = np.linalg.eigvalsh(facts.inertia)
    if 0.0 < abs(small) < MIN_INERTIA_RATIO * large:  # a needle, but for rounding
        _widen(link, 2.0 * MIN_INERTIA_RATIO * large)
        small, middle, large = np.linalg.eigvalsh(facts.inertia + 2.0 * MIN_INERTIA_RATIO * large * np.eye(3))
    lacking = max(large - middle - small, MIN_MASS_KG - small if small <= 0.0 else -large)
    if lacking > -INERTIA_ROUNDED * large:
        _widen(link, lacking + INERTIA_ROUNDED * large)
    if lacking <= INERTIA_ROUNDED * large:
        return ""
    return f"no body has its inertia; {lacking:.2g} kg m² put on each of its moments"


def _make_light(link: Element) -> None:
    for old in link.findall("inertial"):
        link.remove(old)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "mass", value=repr(MIN_MASS_KG))
    moments = {f"i{axis}{axis}": repr(MIN_MASS_KG) for axis in "xyz"}
    SubElement(inertial, "inertia", {**moments, "ixy": "0", "ixz": "0", "iyz": "0"})


def _widen(link: Element, by: float) -> None:
    """Add the same amount, in [kg m²], to each moment of inertia of a link."""
    inertial = next(link.iter("inertial"))
    inertia = inertial.find("inertia")
    if inertia is None:
        inertia = SubElement(inertial, "inertia")
    for name in ("ixx", "iyy", "izz"):
        inertia.set(name, repr(float(inertia.get(name, "0")) + float(by)))
