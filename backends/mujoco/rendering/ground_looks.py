"""Appearance of floors and fields for people."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray

FLOOR_SIDE, GRASS_SIDE = 2.4, 5.0  # [m] after which the picture begins again
_PIXELS = 768
_BOARDS, _LONG = 20, 2  # planks across a picture of the floor, and one after the other
_OAK, _SEAM = np.array([196.0, 168.0, 132.0]), 0.72
_SOIL, _GREEN = np.array([112.0, 96.0, 70.0]), np.array([104.0, 124.0, 66.0])


@cache
def floor_picture() -> ByteArray:
    """Return a picture (n, n, 3) in RGB of planks, each a little lighter or darker than its neighbours."""
    rng = np.random.default_rng(7)
    wide, long = _PIXELS // _BOARDS, _PIXELS // _LONG
    picture = np.zeros((wide * _BOARDS, _PIXELS, 3))
    for board in range(_BOARDS):
        row = np.zeros((wide, _PIXELS, 1))
        for piece in range(_LONG):
            row[:, piece * long : (piece + 1) * long] = rng.uniform(0.93, 1.05)
            row[:, piece * long : piece * long + 2] *= _SEAM
        grain = cv2.GaussianBlur(rng.normal(0.0, 0.12, (wide, _PIXELS)), (61, 1), 0)[..., None]
        row = (row + grain) * _OAK
        row[0] *= _SEAM
        shifted = np.roll(row, int(rng.integers(_PIXELS)), axis=1)
        picture[board * wide : (board + 1) * wide] = shifted
    return np.asarray(np.clip(picture, 0, 255), dtype=np.uint8)


@cache
def grass_picture() -> ByteArray:
    """Return a picture (n, n, 3) in RGB of short grass on soil, which can be repeated without a visible
    edge.
    """
    rng = np.random.default_rng(8)
    share = np.clip(0.55 + 1.6 * _clouds(rng, 30.0) + 0.7 * _clouds(rng, 6.0), 0.0, 1.0)[..., None]
    blades = 1.0 + 0.5 * _clouds(rng, 1.5)[..., None]
    shown = (share * _GREEN + (1.0 - share) * _SOIL) * blades
    return np.asarray(np.clip(shown, 0, 255), dtype=np.uint8)


def _clouds(rng: np.random.Generator, size: float) -> FloatArray:
    """Return smooth periodic noise (n, n) without unit, with sigma 0.25.

    Args:
        rng: source of the noise.
        size: sigma of the smoothing, in [px].
    """
    noise = np.fft.rfft2(rng.standard_normal((_PIXELS, _PIXELS)))
    down, across = np.fft.fftfreq(_PIXELS)[:, None], np.fft.rfftfreq(_PIXELS)[None]
    smooth = np.fft.irfft2(noise * np.exp(-2.0 * (np.pi * size) ** 2 * (down**2 + across**2)))
    return np.asarray(0.25 * smooth / smooth.std())
