"""The look of a box: a mesh whose faces show parts of one picture."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from handcart.backends.physics.engine.thing_form import BOX_FACES, BOX_NORMALS, Uvs
from handcart.robotics.numerics.arrays import FloatArray

from .bullet import bullet, quiet


def box_mesh(client: int, size: Sequence[float], uvs: Sequence[Uvs]) -> int:
    """Return Bullet's visual shape of a box, centred at its middle.

    Args:
        client: Bullet's client.
        size: (3,) lengths in [m].
        uvs: four corners of each face in the texture, in the order of `ThingForm.uvs`.
    """
    p = bullet()
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "box.obj"
        path.write_text(_obj(np.array(size) / 2, uvs), encoding="utf-8")
        return int(
            p.createVisualShape(
                p.GEOM_MESH,
                fileName=str(path),
                rgbaColor=(1.0, 1.0, 1.0, 1.0),
                specularColor=(0.0, 0.0, 0.0),
                physicsClientId=client,
            )
        )


def _obj(half: FloatArray, uvs: Sequence[Uvs]) -> str:
    """Return the box as Wavefront OBJ: Bullet's EGL renderer takes meshes from files only."""
    lines = [f"v {x} {y} {z}" for face in BOX_FACES for x, y, z in half * face]
    lines += [f"vt {u} {v}" for face in uvs for u, v in face]
    lines += [f"vn {x} {y} {z}" for x, y, z in BOX_NORMALS]
    for number in range(len(BOX_FACES)):
        a, b, c, d = (f"{4 * number + i}/{4 * number + i}/{number + 1}" for i in (1, 2, 3, 4))
        lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    return "\n".join(lines) + "\n"
