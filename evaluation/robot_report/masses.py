"""Check of the plausibility of the masses in a URDF."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from handcart.robotics.kinematics.shapes import Box, Cylinder, Hull, Shape, Sphere
from handcart.robotics.kinematics.urdf_contents import INERTIA_ROUNDED, LinkFacts

LIGHT, HEAVY = 50.0, 12000.0  # of a link, mass by volume of its bodies [kg/m³]: foam to lead
MAX_OUTSIDE_M = 0.03  # from a centre of mass to the link's bodies


def mass_faults(link: LinkFacts, bodies: Sequence[Shape], moves: bool = False) -> list[str]:
    """Return messages about implausible mass and inertia of a link.

    Reported are a missing mass or one that is not positive, an inertia that no rigid body has, a density
    outside `LIGHT` to `HEAVY` [kg/m³], and a centre of mass or an inertia beyond the size of the link's
    bodies.

    Args:
        link: the link in its URDF.
        bodies: collision bodies of the link, in the link's frame.
        moves: whether a joint moves the link.
    """
    if link.mass is None and moves and not bodies:
        return ["no mass, and a joint moves it: engines give it one millionth of a kilogram"]
    if link.mass is None:
        return ["no mass: an engine takes it as nearly weightless"] if bodies else []
    if link.mass <= 0.0:
        return [f"a mass of {link.mass:g} kg"]
    return [*_inertia_faults(link), *(_body_faults(link, link.mass, bodies) if bodies else [])]


def _inertia_faults(link: LinkFacts) -> list[str]:
    small, middle, large = np.linalg.eigvalsh(link.inertia)
    if small <= 0.0:
        return ["its inertia isn't that of a body: not positive"]
    if (beyond := large - small - middle) > INERTIA_ROUNDED * large:
        sum_of = f"{large:.3g} > {small:.3g} + {middle:.3g} kg m²"
        return [f"its inertia isn't that of a body: {sum_of}, by {beyond:.2g}"]
    return []


def _body_faults(link: LinkFacts, mass: float, bodies: Sequence[Shape]) -> list[str]:
    corners = np.vstack([corners_of(body) for body in bodies])
    low, high = corners.min(axis=0), corners.max(axis=0)
    faults = []
    beside = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - link.middle, link.middle - high))))
    if beside > MAX_OUTSIDE_M:
        faults.append(f"its middle of mass lies {1e3 * beside:.0f} mm outside its bodies")
    widest = float(np.linalg.norm(np.maximum(high - link.middle, link.middle - low)))
    gyration = float(np.sqrt(np.linalg.eigvalsh(link.inertia)[-1] / mass))
    if gyration > widest:
        faults.append(f"its inertia is that of {1e3 * gyration:.0f} mm radius; it is {1e3 * widest:.0f} mm")
    density = mass / sum(volume_of(body) for body in bodies)
    if not LIGHT < density < HEAVY:
        faults.append(f"{mass:g} kg in its bodies make {density:.0f} kg/m³")
    return faults


def corners_of(shape: Shape) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return points (n, 3) whose convex hull is a body, in the frame of the body's pose, in [m].

    For a round body the hull is exact to 2 %.
    """
    match shape:
        case Hull():
            points = shape.points
        case Box():
            points = _SIGNS * np.array(shape.size) / 2
        case Cylinder():
            ends = [np.c_[shape.radius * _CIRCLE, np.full(len(_CIRCLE), z)] for z in (-0.5, 0.5)]
            points = np.vstack(ends) * (1.0, 1.0, shape.length)
        case Sphere():
            tilted = [np.c_[_CIRCLE * c, np.full(len(_CIRCLE), s)] for c, s in _LATITUDES]
            points = shape.radius * np.vstack(tilted)
    return np.asarray(points @ shape.pose[:3, :3].T + shape.pose[:3, 3])


def volume_of(shape: Shape) -> float:
    """Return the volume of a body, in [m³]."""
    match shape:
        case Hull():
            return float(ConvexHull(shape.points).volume)
        case Box():
            return math.prod(shape.size)
        case Cylinder():
            return math.pi * shape.radius**2 * shape.length
        case Sphere():
            return 4.0 / 3.0 * math.pi * shape.radius**3


_SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
_ANGLES = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
_CIRCLE = np.c_[np.cos(_ANGLES), np.sin(_ANGLES)]
_LATITUDES = [(float(np.cos(a)), float(np.sin(a))) for a in np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)]
