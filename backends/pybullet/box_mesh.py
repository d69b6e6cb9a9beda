"""The look of a box or cylinder: a mesh whose faces show parts of one picture."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from handcart.backends.physics.engine.form_mesh import FormMesh, form_mesh
from handcart.backends.physics.engine.thing_form import Uvs

from .bullet import bullet, quiet


def box_mesh(client: int, size: Sequence[float], uvs: Sequence[Uvs], is_round: bool = False) -> int:
    """Return Bullet's visual shape of a box or cylinder, centred at its middle.

    Args:
        client: Bullet's client.
        size: (3,) lengths along x, y and z, in [m].
        uvs: four corners (u, v), 0 to 1, of each face in the texture; faces -x, +x, -y, +y, +z, -z.
        is_round: True for a cylinder along z.
    """
    p = bullet()
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "box.obj"
        path.write_text(_obj(form_mesh(size, uvs, is_round)), encoding="utf-8")
        return int(
            p.createVisualShape(
                p.GEOM_MESH,
                fileName=str(path),
                rgbaColor=(1.0, 1.0, 1.0, 1.0),
                specularColor=(0.0, 0.0, 0.0),
                physicsClientId=client,
            )
        )


def _obj(mesh: FormMesh) -> str:
    """Return the surface as Wavefront OBJ: Bullet's EGL renderer takes meshes from files only."""
    lines = [f"v {x} {y} {z}" for face in mesh.corners for x, y, z in face]
    lines += [f"vt {u} {v}" for face in mesh.uvs for u, v in face]
    lines += [f"vn {x} {y} {z}" for x, y, z in mesh.normals]
    for number in range(len(mesh.corners)):
        a, b, c, d = (f"{4 * number + i}/{4 * number + i}/{number + 1}" for i in (1, 2, 3, 4))
        lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    return "\n".join(lines) + "\n"
