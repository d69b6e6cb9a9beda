"""Colours of the view; colour-blind viewers can distinguish those of outcomes."""

from __future__ import annotations

import colorsys
from zlib import crc32

Rgb = tuple[int, int, int]

RAY_RGB: Rgb = (158, 214, 186)
HIT_RGB: Rgb = (0, 128, 92)
PLANNED_RGB: Rgb = (47, 99, 201)
DRIVEN_RGB: Rgb = (30, 34, 40)
RESTORED_RGB: Rgb = (224, 123, 0)
BUMPED_RGB: Rgb = (213, 94, 0)
PEOPLE_RGB: Rgb = (204, 51, 119)
CLOUD_RGB: Rgb = (126, 63, 178)
WALL_RGB: Rgb = (173, 182, 194)
FURNITURE_RGB: Rgb = (196, 160, 117)
GROUND_RGB: Rgb = (214, 219, 209)
FLOOR_RGB: Rgb = (238, 240, 243)


def of_solid(grey: int | None) -> Rgb:
    """Return the RGB colour of a fixed solid: grey, or the colour of furniture if no grey value is known."""
    return FURNITURE_RGB if grey is None else (grey, grey, grey)


def of_thing(name: str, grey: int) -> Rgb:
    """Return the colour of a thing: brightness by its grey value, hue by its name to distinguish
    neighbours.
    """
    number = crc32(name.encode())
    hue, full = (number % 360) / 360.0, 0.22 + 0.28 * ((number >> 12) % 100) / 100.0
    bright = 0.35 + 0.6 * grey / 255.0
    red, green, blue = colorsys.hsv_to_rgb(hue, full, min(1.0, bright))
    return round(255 * red), round(255 * green), round(255 * blue)
