"""The solid of a book with rounded leading edges."""

from __future__ import annotations

import tempfile
from pathlib import Path

from handcart.backends.pybullet.engine import quiet
from handcart.backends.pybullet.physics import Physics

CHAMFER = 0.003  # of the leading edges: covers are rounded [m]
HULL_MARGIN = 0.001  # that Bullet adds about a hull [m]


def rounded_book(physics: Physics, size: tuple[float, float, float]) -> int:
    """A collision shape of `size` (depth, thickness, height) in [m], its edges away from the spine cut off.

    A box with a blunt wedge before it: fingers hold the box, whose contacts Bullet knows to be flat, while
    of a hull it finds one point at a time, about which a gripped book would turn and on which it would hook.
    """
    p = physics.p
    depth, thickness, height = (length / 2 for length in size)
    core = (depth - CHAMFER / 2, thickness, height)
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "wedge.obj"
        path.write_text(_wedge(depth - CHAMFER, depth, thickness, height), encoding="utf-8")
        return int(
            p.createCollisionShapeArray(
                shapeTypes=[p.GEOM_BOX, p.GEOM_MESH],
                halfExtents=[core, (0.0, 0.0, 0.0)],
                fileNames=["", str(path)],
                collisionFramePositions=[(-CHAMFER / 2, 0.0, 0.0), (0.0, 0.0, 0.0)],
                physicsClientId=physics.client,
            )
        )


def _wedge(base: float, end: float, half_thickness: float, half_height: float) -> str:
    """Wavefront OBJ of a prism from the face at x = `base` to the narrower one at x = `end` ahead."""
    y, z = half_thickness - HULL_MARGIN, half_height - HULL_MARGIN
    blunt = end - HULL_MARGIN
    corners = [(base, -y), (base, y), (blunt, y - CHAMFER), (blunt, CHAMFER - y)]
    lines = [f"v {x} {across} {up}" for up in (-z, z) for x, across in corners]
    quads = [(1, 2, 3, 4), (8, 7, 6, 5), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]
    return "\n".join([*lines, *(f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads)]) + "\n"
