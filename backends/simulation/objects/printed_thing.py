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
    """Simulated thing with pictures printed on its sides, such as tags; a fault can replace them."""

    @override
    def faces(self) -> Mapping[Side, GreyImage]:
        return self._faces

    def print_over(self, faces: Mapping[Side, GreyImage]) -> None:
        """Replace all pictures on the thing's sides, to simulate damaged or covered tags.

        Args:
            faces: new picture (h, w), grey from 0 to 255, of each side that is to have a picture.
        """
        self.__dict__["_faces"] = dict(faces)

    def cover_print(self) -> None:
        """Cover all pictures on the thing with the grey of its sides, so that no tag can be seen."""
        self.print_over({side: np.full_like(face, self.grey) for side, face in self.faces().items()})

    @abstractmethod
    def draw_faces(self) -> Mapping[Side, GreyImage]:
        """Return the undamaged grey pictures (h, w) of the thing's printed sides."""

    @cached_property
    def _faces(self) -> Mapping[Side, GreyImage]:
        return self.draw_faces()
