"""What of a robot's URDF MuJoCo can't take, and what is made of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

LIGHTEST = 1e-6  # of a link that moves and is only a frame [kg], and its inertia [kg m²]


class Repair(NamedTuple):
    """A link that isn't as its maker wrote it."""

    link: str
    what: str

    def __str__(self) -> str:
        return f"link {self.link!r}: {self.what}"


def repaired(bodies: Iterator[Any]) -> list[Repair]:
    """Give links of an `MjSpec` masses and inertia that bodies can have; tells what was done."""
    return [Repair(body.name, what) for body in bodies if (what := _repair(body))]


def _repair(body: Any) -> str:
    if not body.explicitinertial:
        if not body.joints:
            return ""  # its mass is none: it is a frame on what carries it
        body.explicitinertial, body.ipos = True, (0.0, 0.0, 0.0)
        body.mass, body.inertia = LIGHTEST, (LIGHTEST,) * 3
        return f"it moves and has no mass; given {LIGHTEST:g} kg and {LIGHTEST:g} kg m²"
    lacking = _lacking(body)
    if lacking <= 0.0:
        return ""
    if np.isfinite(body.fullinertia[0]):
        body.fullinertia = body.fullinertia + lacking * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    else:
        body.inertia = body.inertia + lacking
    return f"no body has its inertia, one larger than the two others; {lacking:.2g} kg m² put on each"


def _lacking(body: Any) -> float:
    """By how much the largest principal moment is beyond the sum of the others, in [kg m²]."""
    full = body.fullinertia
    if np.isfinite(full[0]):
        xx, yy, zz, xy, xz, yz = full
        moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        moments = np.sort(body.inertia)
    return float(moments[2] - moments[0] - moments[1])
