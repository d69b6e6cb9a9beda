"""The solid of a book with rounded upright edges."""

from __future__ import annotations

import tempfile
from pathlib import Path

from .engine import quiet
from .physics import Physics

CHAMFER = 0.003  # of the edges: covers are rounded [m]
HULL_MARGIN = 0.001  # that Bullet adds about a hull [m]


def rounded_book(physics: Physics, size: tuple[float, float, float]) -> int:
    """A collision shape of `size` (depth, thickness, height) in [m], its upright edges cut off.

    A box with a blunt wedge before and behind: the fingers hold the box, whose contacts Bullet knows to be
    flat, while of a hull it finds one point at a time, about which a gripped book would turn.
    """
    p = physics.p
    depth, thickness, height = (length / 2 for length in size)
    core = (depth - CHAMFER, thickness, height)
    with tempfile.TemporaryDirectory() as folder, quiet():
        wedges = []
        for name, side in (("front", 1.0), ("rear", -1.0)):
            path = Path(folder) / f"{name}.obj"
            path.write_text(_wedge(side * core[0], side * depth, thickness, height), encoding="utf-8")
            wedges.append(str(path))
        return int(
            p.createCollisionShapeArray(
                shapeTypes=[p.GEOM_BOX, p.GEOM_MESH, p.GEOM_MESH],
                halfExtents=[core, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)],
                fileNames=["", *wedges],
                physicsClientId=physics.client,
            )
        )


def _wedge(base: float, end: float, half_thickness: float, half_height: float) -> str:
    """Wavefront OBJ of a prism from the face at x = `base` to the narrower one at x = `end`."""
    y, z = half_thickness - HULL_MARGIN, half_height - HULL_MARGIN
    blunt = end - HULL_MARGIN * (1.0 if end > base else -1.0)
    corners = [(base, -y), (base, y), (blunt, y - CHAMFER), (blunt, CHAMFER - y)]
    lines = [f"v {x} {across} {up}" for up in (-z, z) for x, across in corners]
    quads = [(1, 2, 3, 4), (8, 7, 6, 5), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]
    return "\n".join([*lines, *(f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads)]) + "\n"
