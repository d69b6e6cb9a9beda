"""Check that the meshes of a URDF exist, and how much of their convex hull they fill."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from handcart.files.suggest import did_you_mean
from handcart.robotics.kinematics.coal_bodies import hull_of_mesh, read_mesh
from handcart.robotics.kinematics.urdf_contents import MeshUse

MIN_CONVEX_SHARE = 0.9  # of its convex hull that a convex mesh fills


@dataclass(frozen=True)
class MeshRow:
    """Result of checking whether one mesh of a URDF exists, and how convex it is."""

    link: str
    kind: str
    """Either `collision` or `visual`."""
    file: str
    found: bool
    corners: int = 0
    filled: float | None = None
    """Share of its convex hull that it fills; None for visual meshes and for meshes that are not closed."""
    hint: str = ""
    """Name of a similar file, if the mesh is missing."""

    @property
    def fault(self) -> str | None:
        """Message that the mesh is missing, or that a collision mesh is concave; None without such a
        fault.
        """
        if not self.found:
            return f"missing{self.hint}"
        if self.filled is None or self.filled >= MIN_CONVEX_SHARE:
            return None
        return f"concave: fills {100 * self.filled:.0f} % of its hull; the hull counts"


def mesh_row(use: MeshUse) -> MeshRow:
    """Return whether a mesh file exists and, for a collision mesh, which share of its convex hull it
    fills.
    """
    path, name = Path(use.file), Path(use.file).name
    if not path.is_file():
        meant = did_you_mean(path).rstrip(" ")
        return MeshRow(use.link, use.kind, name, found=False, hint=f"; {meant}" if meant else "")
    if use.kind == "visual":
        return MeshRow(use.link, use.kind, name, found=True)
    mesh = read_mesh(str(path), use.scale)
    hull = hull_of_mesh(mesh, use.link)
    filled = mesh.computeVolume() / hull.computeVolume()  # type: ignore[attr-defined]
    closed = 0.0 < filled <= 1.0 + 1e-6
    corners = int(mesh.num_vertices)  # type: ignore[attr-defined]
    return MeshRow(use.link, use.kind, name, True, corners, min(1.0, filled) if closed else None)
