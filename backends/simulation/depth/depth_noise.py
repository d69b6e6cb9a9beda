"""Errors of a depth picture."""

from __future__ import annotations

import math
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.backends.simulation.noise.keyed_noise import keyed
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

Scalar = TypeVar("Scalar", bound=np.generic)


class DepthNoise:
    """Conversion of true depths to a depth camera's readings, with the errors set in the robot's file."""

    def __init__(self, spec: DepthCameraSpec, seed: int) -> None:
        """Draw the errors that stay the same for a run."""
        self._spec, self._errors, self._seed = spec, spec.errors, seed
        self._scale = 1.0 + spec.errors.scale_percent / 100 * keyed(seed, "depth scale").standard_normal()
        self._rays = _rays(spec.model)

    def read(self, true: FloatArray, period: int) -> SingleArray:
        """Return the depths (h, w) that a camera reads in a period, in [m]; NaN without a reading.

        Args:
            true: (h, w) true depths along the optical axis, in [m]; infinite where nothing is.
            period: number of the period.
        """
        errors, rng = self._errors, keyed(self._seed, "depth", period)
        drawn, dropped = rng.standard_normal(true.shape), rng.random(true.shape)
        beyond = np.maximum(np.where(np.isfinite(true), true, 0.0) - errors.sigma_from_m, 0.0)
        sigma = (errors.sigma_mm + errors.sigma_mm_per_m2 * beyond**2) / 1e3
        depth = np.where(np.isfinite(true), true, np.nan) * self._scale + sigma * drawn
        lost = self.steps(true) | self.grazing(true) | (dropped < errors.dropout_percent / 100)
        with np.errstate(invalid="ignore"):
            lost |= (depth < self._spec.range_min_m) | (depth > self._spec.reach_m)
        depth[lost] = np.nan
        return depth.astype(np.float32)

    def steps(self, true: FloatArray) -> BoolArray:
        """Return a mask (h, w) of pixels without a reading because they are near a step in depth.

        Args:
            true: (h, w) true depths, in [m]. A step is a pair of neighbouring depths of which the larger
                exceeds the smaller by more than `edge_step_percent` of the camera's errors, in percent. A
                pixel is near a step if it is within `edge_px` pixels of the step.
        """
        if self._errors.edge_px == 0:
            return np.zeros(true.shape, np.bool_)
        share = 1.0 + self._errors.edge_step_percent / 100
        found = np.zeros(true.shape, np.bool_)
        for axis in (0, 1):
            one, other = _neighbours(true, axis)
            step = np.maximum(one, other) > share * np.minimum(one, other)
            for half in _neighbours(found, axis):
                half[step] = True
        side = 2 * self._errors.edge_px - 1
        return cv2.dilate(found.astype(np.uint8), np.ones((side, side), np.uint8)) > 0

    def grazing(self, true: FloatArray) -> BoolArray:
        """Return a mask (h, w) of pixels without a reading because they show a surface at a flat angle.

        Args:
            true: (h, w) true depths, in [m]. An angle is flat if the pixel's ray and the surface's normal are
                more than the spec's `grazing_deg` apart.
        """
        if self._errors.grazing_deg >= 90.0:
            return np.zeros(true.shape, np.bool_)
        points = self._rays * np.where(np.isfinite(true), true, 1e3)[..., None]
        across, down = np.diff(points, axis=1), np.diff(points, axis=0)
        after = self._cosines(_padded(across, 1, -1), _padded(down, 0, -1))
        before = self._cosines(_padded(across, 1, 0), _padded(down, 0, 0))
        return np.asarray(np.maximum(after, before) < math.cos(math.radians(self._errors.grazing_deg)))

    def _cosines(self, across: FloatArray, down: FloatArray) -> FloatArray:
        """Return the cosine (h, w) between a pixel's ray and the normal of the surface that it shows, 0 to 1.

        Args:
            across: (h, w, 3) difference of the surface's points at neighbouring columns, in [m].
            down: (h, w, 3) difference of the surface's points at neighbouring rows, in [m].
        """
        normals = np.cross(across, down)
        lengths = np.linalg.norm(normals, axis=2) * np.linalg.norm(self._rays, axis=2)
        return np.asarray(np.abs((normals * self._rays).sum(axis=2)) / np.maximum(lengths, 1e-12))


def _rays(model: CameraModel) -> FloatArray:
    """Return the rays (h, w, 3) of the pixels in the optical frame, of length 1 along the optical axis."""
    rows, columns = np.indices((model.height, model.width), dtype=np.float64)
    flat = model.undistort(np.column_stack((columns.ravel(), rows.ravel())))
    return np.column_stack((flat, np.ones(len(flat)))).reshape(model.height, model.width, 3)


def _neighbours(values: NDArray[Scalar], axis: int) -> tuple[NDArray[Scalar], NDArray[Scalar]]:
    """Return views of all pixels but the last ones along an axis, and of their next neighbours."""
    if axis == 0:
        return values[:-1], values[1:]
    return values[:, :-1], values[:, 1:]


def _padded(slopes: FloatArray, axis: int, at: int) -> FloatArray:
    """Return differences of neighbouring pixels with the first or last ones repeated, so that each pixel has
    one.

    Args:
        slopes: (h - 1, w, 3) or (h, w - 1, 3) differences.
        axis: axis along which one is missing.
        at: 0 to repeat the first ones, -1 to repeat the last ones.
    """
    twice = np.take(slopes, [at], axis=axis)
    return np.concatenate((twice, slopes) if at == 0 else (slopes, twice), axis=axis)
