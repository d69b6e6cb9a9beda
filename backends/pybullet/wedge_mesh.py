"""Wedges as meshes that Bullet takes for hulls."""

from __future__ import annotations

from handcart.backends.physics.thing_form import Wedge

HULL_MARGIN = 0.001  # that Bullet adds about a hull [m]


def wedge_mesh(wedge: Wedge) -> str:
    """Wavefront OBJ of a wedge, smaller by what Bullet adds."""
    y, z = wedge.thickness / 2 - HULL_MARGIN, wedge.height / 2 - HULL_MARGIN
    blunt, in_y = wedge.end - HULL_MARGIN, wedge.chamfer
    corners = [(wedge.base, -y), (wedge.base, y), (blunt, y - in_y), (blunt, in_y - y)]
    lines = [f"v {x} {across} {up}" for up in (-z, z) for x, across in corners]
    quads = [(1, 2, 3, 4), (8, 7, 6, 5), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]
    return "\n".join([*lines, *(f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads)]) + "\n"
