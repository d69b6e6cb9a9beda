"""How a stage is lit and coloured."""

from __future__ import annotations

from typing import NamedTuple


class Style(NamedTuple):
    """For whom pictures are made."""

    coloured: bool
    """In colours, or in the greys that a camera sees."""
    even: float
    """Light from everywhere: 1 shows all as bright as it is painted."""
    lamp: float
    """Of one lamp, its shadows included."""
    shadow_px: int
    """Size of the map of its shadows; 0: none."""
    lit_m: float
    """How far about what is looked at there are shadows, in [m]."""
    samples: int
    """Of a pixel, so that edges have no steps; 0: one."""
    beam: tuple[float, float, float] = (0.25, -0.2, -0.947)
    """Where the lamp shines to: of length 1, in the world."""


FILM = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=1024, lit_m=3.0, samples=0)
STILL_PICTURE = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=4096, lit_m=8.0, samples=8)
CAMERA = Style(coloured=False, even=1.0, lamp=0.0, shadow_px=0, lit_m=1.0, samples=4)
