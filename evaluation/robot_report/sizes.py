"""Check for bodies of implausible size and for meshes that are slow to load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from handcart.backends.urdf.robot_urdf import RobotUrdf
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.kinematics.urdf_contents import MeshUse

from .masses import corners_of
from .remark import Remark

LARGEST_BODY_M = 5.0
LARGEST_MESH_MB = 10.0
MM_PER_M = 1e3


def size_remarks(bodies: Sequence[Shape], meshes: Sequence[MeshUse], whole: RobotUrdf) -> Iterator[Remark]:
    """Yield remarks about too large bodies and mesh files.

    Limits are `LARGEST_BODY_M` for the length of a body and `LARGEST_MESH_MB` for a file.
    """
    for body in bodies:
        size = float(np.ptp(corners_of(body), axis=0).max())
        if size > LARGEST_BODY_M:
            scale = "; if it is in mm: scale='0.001 0.001 0.001'" if size > 0.05 * MM_PER_M else ""
            words = f"a body is {size:.3g} m long; expected: up to {LARGEST_BODY_M:g} m{scale}"
            yield Remark(f"link {body.name!r}", words, whole.finding("link", body.name, words))
    for mesh in {use.file: use for use in meshes}.values():
        file = Path(mesh.file)
        megabytes = file.stat().st_size / 1e6 if file.is_file() else 0.0
        if megabytes > LARGEST_MESH_MB:
            words = f"{mesh.kind} mesh {file.name!r} has {megabytes:.0f} MB: it is slow to load; simplify it"
            yield Remark(f"link {mesh.link!r}", words, whole.finding("link", mesh.link, words))
