"""A book, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from typing_extensions import override

from handcart.backends.simulation.world.material import Material
from handcart.backends.simulation.world.thing import Thing, middle_frame
from handcart.robotics.geometry.transform import Transform

from .spec import BookSpec

CLOTH_MATERIALS = (
    Material(0.55, 0.20, 0.17),
    Material(0.16, 0.32, 0.47),
    Material(0.22, 0.41, 0.30),
    Material(0.78, 0.62, 0.30),
    Material(0.40, 0.26, 0.38),
    Material(0.83, 0.78, 0.68),
    Material(0.72, 0.42, 0.22),
)
"""Materials of covers."""


@dataclass(eq=False, repr=False)
class SimulatedBook(Thing):
    """A simulated book and its true pose.

    The book's frame has its origin at the foot of the spine, in the middle of the thickness; x points from
    the spine to the fore-edge, y to the left as seen facing the spine, z up.
    """

    DENSITY = 700.0
    """Density of paper, in [kg/m³]."""

    spec: BookSpec
    shelf: str | None = None
    """Name of the supporting shelf."""

    def __post_init__(self) -> None:
        self.thickness = self.spec.thickness_mm / 1e3
        self.height = self.spec.height_mm / 1e3
        self.depth = self.spec.depth_mm / 1e3

    @property
    def accession(self) -> int:
        """Accession number of the book (its number in the library), which its tag encodes."""
        return self.spec.accession

    @cached_property
    @override
    def name(self) -> str:
        return f"book {self.accession}"

    @property
    def material(self) -> Material:
        """Material of the book's unprinted sides, a cloth whose colour depends on the accession number."""
        return CLOTH_MATERIALS[self.accession % len(CLOTH_MATERIALS)]

    @property
    def size(self) -> tuple[float, float, float]:
        """Depth, thickness and height of the book, along x, y and z of its frame, in [m]."""
        return self.depth, self.thickness, self.height

    @property
    def carrier(self) -> str:
        """Name of the shelf on which the book is; otherwise the kind of its support, such as "tray" or
        "hand".
        """
        return self.shelf or super().carrier

    @property
    @override
    def thing_T_middle(self) -> Transform:
        return middle_frame(self.depth / 2, self.height / 2)
