"""A box or cylinder with tags printed on its sides."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from typing_extensions import override

from handcart.backends.simulation.world.thing import GreyImage, Side, Thing


@dataclass(eq=False, repr=False)
class PrintedThing(Thing):
    """A thing with pictures printed on its sides: drawn when first seen, and replaceable."""

    @override
    def faces(self) -> Mapping[Side, GreyImage]:
        return self._faces

    def print_over(self, faces: Mapping[Side, GreyImage]) -> None:
        """Replace all pictures on its sides, to simulate damage or something that covers the tags.

        Args:
            faces: picture (h, w) of each side that has one now, grey from 0 to 255.
        """
        self.__dict__["_faces"] = dict(faces)

    def cover_print(self) -> None:
        """Cover all its pictures with the grey of its sides."""
        self.print_over({side: np.full_like(face, self.grey) for side, face in self.faces().items()})

    @abstractmethod
    def draw_faces(self) -> Mapping[Side, GreyImage]:
        """Return the pictures (h, w) of its printed sides, as they are new."""

    @cached_property
    def _faces(self) -> Mapping[Side, GreyImage]:
        return self.draw_faces()
