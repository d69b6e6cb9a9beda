"""A block, as a solid body."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from handcart.robotics.geometry.transform import Transform

from .thing import Thing
from .world_file import BlockSpec


@dataclass(eq=False, repr=False)
class Block(Thing):
    """A block of a wall and where it truly is.

    Its frame: origin in the middle of its foot; x along its length, y along its width, z up.
    """

    spec: BlockSpec
    base_T_block: Transform = field(default_factory=lambda: np.eye(4))
    """Where it stands on the robot's table, as long as it does."""

    @property
    def name(self) -> str:
        """See `Thing`."""
        return f"block {self.spec.name}"

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width, height along x, y, z of its frame, in [m]."""
        length, width, height = self.spec.size_mm
        return length / 1e3, width / 1e3, height / 1e3

    @property
    def thing_T_middle(self) -> Transform:
        """See `Thing`."""
        result = np.eye(4)
        result[2, 3] = self.size[2] / 2
        return result
