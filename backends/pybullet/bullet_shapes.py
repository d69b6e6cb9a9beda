"""Shapes of Bullet's bodies."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from handcart.backends.physics.engine.thing_form import Cuboid, Piece, Rod, Wedge
from handcart.robotics.numerics.arrays import FloatArray

from .bullet import bullet, quiet

_FLOOR = 0.37  # grey
_HULL_MARGIN = 0.001  # margin that Bullet adds around a hull [m]


def floor_look(client: int) -> int:
    """Create a visual shape of a level floor in the Bullet client with number `client`; return the shape's
    number.
    """
    p = bullet()
    return int(
        p.createVisualShape(
            p.GEOM_BOX,
            halfExtents=(40.0, 40.0, 0.005),
            visualFramePosition=(0.0, 0.0, -0.005),
            rgbaColor=(_FLOOR, _FLOOR, _FLOOR, 1.0),
            specularColor=(0.0, 0.0, 0.0),
            physicsClientId=client,
        )
    )


def plain_box(client: int, size: Sequence[float], grey: int) -> tuple[int, int]:
    """Return the numbers of Bullet's collision and visual shape of a box.

    Args:
        client: number of Bullet's client.
        size: (3,) lengths along x, y and z, in [m].
        grey: grey of the visual shape, 0 to 255.
    """
    p, half, shade = bullet(), [length / 2 for length in size], grey / 255
    shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client)
    visual = p.createVisualShape(
        p.GEOM_BOX,
        halfExtents=half,
        rgbaColor=(shade, shade, shade, 1.0),
        specularColor=(0.0, 0.0, 0.0),
        physicsClientId=client,
    )
    return int(shape), int(visual)


def tile_shape(client: int, cell: float, heights: FloatArray) -> tuple[int, int]:
    """Return the numbers of Bullet's collision and visual shape of a square of rough ground.

    Args:
        client: number of Bullet's client.
        cell: distance of neighbouring heights along x and y, in [m].
        heights: (k, k) heights of the ground in [m], a row for each y, ascending, and a column for each x.
    """
    p, count = bullet(), len(heights)
    side = (count - 1) * cell
    shape = p.createCollisionShape(
        p.GEOM_HEIGHTFIELD,
        meshScale=(cell, cell, 1.0),
        heightfieldData=heights.ravel().tolist(),
        numHeightfieldRows=count,
        numHeightfieldColumns=count,
        physicsClientId=client,
    )
    seen = p.createVisualShape(p.GEOM_BOX, halfExtents=(side / 2, side / 2, 0.001), physicsClientId=client)
    return int(shape), int(seen)


def thing_shape(client: int, pieces: Sequence[Piece]) -> int:
    """Create a collision shape of all pieces of a thing, centred at the thing's middle, in the Bullet client
    with number `client`. Return the shape's number.
    """
    p = bullet()
    if len(pieces) == 1 and isinstance(pieces[0], Cuboid) and pieces[0].ahead == 0.0:
        half = [length / 2 for length in pieces[0].size]
        return int(p.createCollisionShape(p.GEOM_BOX, halfExtents=half, physicsClientId=client))
    if len(pieces) == 1 and isinstance(pieces[0], Rod):
        radius, length = pieces[0]
        return int(
            p.createCollisionShape(p.GEOM_CYLINDER, radius=radius, height=length, physicsClientId=client)
        )
    with tempfile.TemporaryDirectory() as folder, quiet():
        kinds, halves, files, places = [], [], [], []
        for number, piece in enumerate(pieces):
            if isinstance(piece, Cuboid):
                kinds.append(p.GEOM_BOX)
                halves.append(tuple(length / 2 for length in piece.size))
                files.append("")
                places.append((piece.ahead, 0.0, 0.0))
            elif isinstance(piece, Wedge):
                path = Path(folder) / f"wedge_{number}.obj"
                path.write_text(_wedge_mesh(piece), encoding="utf-8")
                kinds.append(p.GEOM_MESH)
                halves.append((0.0, 0.0, 0.0))
                files.append(str(path))
                places.append((0.0, 0.0, 0.0))
        return int(
            p.createCollisionShapeArray(
                shapeTypes=kinds,
                halfExtents=halves,
                fileNames=files,
                collisionFramePositions=places,
                physicsClientId=client,
            )
        )


def _wedge_mesh(wedge: Wedge) -> str:
    """Return a wedge as Wavefront OBJ, smaller by the margin that Bullet adds."""
    y, z = wedge.thickness / 2 - _HULL_MARGIN, wedge.height / 2 - _HULL_MARGIN
    blunt, in_y = wedge.end - _HULL_MARGIN, wedge.chamfer
    corners = [(wedge.base, -y), (wedge.base, y), (blunt, y - in_y), (blunt, in_y - y)]
    lines = [f"v {x} {across} {up}" for up in (-z, z) for x, across in corners]
    quads = [(1, 2, 3, 4), (8, 7, 6, 5), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]
    return "\n".join([*lines, *(f"f {a} {b} {c}\nf {a} {c} {d}" for a, b, c, d in quads)]) + "\n"
