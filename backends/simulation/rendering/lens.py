"""Effects of lens, light and sensor on an ideal picture."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from handcart.backends.description.simulated_errors import Errors
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.numerics.arrays import ByteArray, Int16Array, SingleArray, Uint16Array
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.lens_fold import LensKind

_SPARE = 256  # how much larger the tile of noise is than a picture [px]


class Lens:
    """Conversion of an ideal pinhole camera's picture to the picture that the camera takes.

    Each pixel looks along the ray that `CameraModel.undistort` returns for it. `K` (3, 3) and `size` (width,
    height) in [px] belong to the ideal picture, which is larger to hold the rays of all pixels. Light falls
    off across the picture in a direction drawn from the run's seed. Noise is cut from one tile of Gaussian
    noise at an offset that changes with each control period: pixels of a picture are independent, and the
    noise of two pictures differs by a shift.
    """

    def __init__(self, camera: CameraModel, errors: Errors, seed: int) -> None:
        self._seed, self._errors = seed, errors
        self._shape = (camera.height, camera.width)
        sources = _sources(camera.K.tobytes(), camera.distortion.tobytes(), *self._shape, camera.lens)
        self._maps, self.size = sources.maps, sources.size
        focal, (left, top) = camera.K[0, 0], sources.corner
        self.K = np.array([[focal, 0.0, -left], [0.0, focal, -top], [0.0, 0.0, 1.0]])
        self._gain = self._light()
        tile = (self._shape[0] + _SPARE, self._shape[1] + _SPARE)
        noise = keyed(seed, "noise tile").standard_normal(tile, dtype=np.float32)
        self._noise = noise * np.float32(errors.image_noise_grey)

    def _light(self) -> SingleArray:
        """Return the gain (h, w) of each pixel."""
        angle = keyed(self._seed, "light").uniform(-math.pi, math.pi)
        height, width = self._shape
        columns, rows = np.arange(width) / width - 0.5, np.arange(height) / height - 0.5
        across = columns * math.cos(angle) + (rows * math.sin(angle))[:, None]
        return (1.0 + self._errors.light_gradient * across).astype(np.float32)

    def take(self, ideal: ByteArray, period: int) -> ByteArray:
        """Return the picture (h, w), grey, that the lens makes of an ideal one.

        Args:
            ideal: (H, W) grey picture of a pinhole camera, as wide and high as the lens's `size`.
            period: number of the period, which decides the noise.
        """
        picture = cv2.remap(ideal, self._maps[0], self._maps[1], cv2.INTER_LINEAR)
        if self._errors.image_blur_px > 0.0:
            picture = cv2.GaussianBlur(picture, (5, 5), self._errors.image_blur_px)
        height, width = self._shape
        top, left = keyed(self._seed, "image", period).integers(0, _SPARE, 2)
        lit = cv2.multiply(picture, self._gain, dtype=cv2.CV_32F)
        noisy = cv2.add(lit, self._noise[top : top + height, left : left + width])
        return cv2.convertScaleAbs(np.maximum(noisy, 0.0)).astype(np.uint8, copy=False)


class _Sources(NamedTuple):
    """Points of an ideal picture that a camera's pixels show."""

    maps: tuple[Int16Array, Uint16Array]
    """Points as OpenCV's `remap` takes them in whole numbers: (h, w, 2) and (h, w)."""
    size: tuple[int, int]
    """Width and height of the ideal picture, in [px]."""
    corner: tuple[float, float]
    """Column and row of the ideal picture's first pixel, from where the optical axis meets it, in [px]."""


@lru_cache(maxsize=4)
def _sources(K: bytes, distortion: bytes, height: int, width: int, lens: LensKind) -> _Sources:
    """Return the points that all pixels show; cached because they are costly.

    Args:
        K: (3, 3) camera matrix in [px], as bytes.
        distortion: distortion coefficients in OpenCV's order, as bytes.
        height: height of the picture, in [px].
        width: width of the picture, in [px].
        lens: kind of the lens model.
    """
    camera = CameraModel(np.frombuffer(K).reshape(3, 3), np.frombuffer(distortion), width, height, lens)
    rows, columns = np.indices((height, width), dtype=np.float64)
    rays = camera.undistort(np.column_stack((columns.ravel(), rows.ravel())))
    focal = camera.K[0, 0]
    low, high = np.floor(rays.min(axis=0) * focal) - 2, np.ceil(rays.max(axis=0) * focal) + 2
    source = (rays * focal - low).astype(np.float32).reshape(height, width, 2)
    columns_of, rows_of = (np.ascontiguousarray(source[..., i]) for i in (0, 1))
    whole, rest = cv2.convertMaps(columns_of, rows_of, cv2.CV_16SC2)
    maps = np.asarray(whole, dtype=np.int16), np.asarray(rest, dtype=np.uint16)
    size = int(high[0] - low[0]) + 1, int(high[1] - low[1]) + 1
    return _Sources(maps, size, (float(low[0]), float(low[1])))
