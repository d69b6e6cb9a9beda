"""Light and colours of a stage."""

from __future__ import annotations

from typing import NamedTuple


class Style(NamedTuple):
    """Light and colours of rendered pictures, either for people or as readings of simulated cameras."""

    coloured: bool
    """True for colours, False for the greys of a camera."""
    even: float
    """Brightness of the light from everywhere: with 1 each surface is as bright as its paint."""
    lamp: float
    """Brightness of the lamp, which casts the shadows."""
    shadow_px: int
    """Width and height of the lamp's shadow map, in [px]; 0: no shadows."""
    lit_m: float
    """Radius of the region with shadows, in [m]."""
    samples: int
    """Samples per pixel, which smooth edges; 0 means one sample."""
    beam: tuple[float, float, float] = (0.25, -0.2, -0.947)
    """Direction (3,) in which the lamp shines, a unit vector in the world."""


FILM_STYLE = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=1024, lit_m=3.0, samples=0)
STILL_PICTURE = Style(coloured=True, even=0.46, lamp=0.42, shadow_px=4096, lit_m=8.0, samples=8)

CAMERA_STYLE = Style(coloured=False, even=1.0, lamp=0.0, shadow_px=0, lit_m=1.0, samples=4)
