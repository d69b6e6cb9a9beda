"""Light and colours of a stage."""

from __future__ import annotations

from typing import NamedTuple


class Style(NamedTuple):
    """Light and colours of rendered pictures, for people or for cameras."""

    coloured: bool
    """True for colours, False for the greys of a camera."""
    even: float
    """Light from everywhere: 1 shows all as bright as it is painted."""
    lamp: float
    """Brightness of one lamp, including its shadows."""
    shadow_px: int
    """Size of the map of its shadows; 0: none."""
    lit_m: float
    """Radius of the region with shadows, in [m]."""
    samples: int
    """Samples per pixel, which smooth edges; 0 means one."""
    beam: tuple[float, float, float] = (0.25, -0.2, -0.947)
    """Direction of the lamp: of length 1, in the world."""


FILM_STYLE = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=1024, lit_m=3.0, samples=0)
STILL_PICTURE = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=4096, lit_m=8.0, samples=8)

CAMERA_STYLE = Style(coloured=False, even=1.0, lamp=0.0, shadow_px=0, lit_m=1.0, samples=4)
