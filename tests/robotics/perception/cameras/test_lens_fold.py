"""Lens models with 4, 5 and 8 coefficients, fisheye lenses, and where they fold back."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.lens_fold import fold_radius
from handcart.robotics.perception.landmarks.constellation import Kind
from handcart.robotics.perception.landmarks.landmark_in_view import wholly_in_view

RATIONAL = [0.52, -0.21, 1e-4, -3e-4, 0.011, 0.85, -0.12, 0.004]
LENSES: list[tuple[Any, list[float]]] = [
    ("brown", [-0.28, 0.09, 1e-3, -5e-4]),
    ("brown", [-0.28, 0.09, 1e-3, -5e-4, -0.01]),
    ("brown", RATIONAL),
    ("fisheye", [-0.02, 0.004, -0.002, 0.0003]),
]


def camera(lens: Any, distortion: list[float], focal: float = 500.0) -> CameraModel:
    K = np.array([[focal, 0.0, 320.0], [0.0, 1.02 * focal, 240.0], [0.0, 0.0, 1.0]])
    return CameraModel(K, np.array(distortion), 640, 480, lens)


@pytest.mark.parametrize(("lens", "distortion"), LENSES)
def test_rays_come_back_from_their_pixels(lens: Any, distortion: list[float]) -> None:
    model = camera(lens, distortion)
    x, y = np.meshgrid(np.linspace(-0.6, 0.6, 7), np.linspace(-0.4, 0.4, 5))
    rays = np.column_stack([x.ravel(), y.ravel()])
    pixels = model.project(np.column_stack([rays, np.ones(len(rays))]))
    assert model.undistort(pixels) == pytest.approx(rays, abs=1e-6)


@pytest.mark.parametrize(("lens", "distortion"), LENSES)
def test_rectified_picture_shows_each_ray_at_its_place(lens: Any, distortion: list[float]) -> None:
    """A picture with a smooth ramp along x: rectified, it has at each place what its ray meets."""
    model = camera(lens, distortion)
    columns = np.tile(np.arange(640, dtype=np.float64) / 4.0, (480, 1)).astype(np.uint8)
    picture_to_rays = np.array([[1e-3, 0.0, -0.2], [0.0, 1e-3, -0.1], [0.0, 0.0, 1.0]])
    flat = model.rectify(columns, picture_to_rays, (400, 200))
    row, column = 120, 330
    ray = picture_to_rays @ [column, row, 1.0]
    seen_at = model.project(ray.reshape(1, 3))[0, 0]
    assert float(flat[row, column]) == pytest.approx(seen_at / 4.0, abs=1.0)


def test_fisheye_is_that_of_opencv() -> None:
    model = camera("fisheye", LENSES[3][1])
    point = np.array([[0.3, -0.2, 0.5]])
    found, _ = cv2.fisheye.projectPoints(
        point.reshape(1, 1, 3), np.zeros(3), np.zeros(3), model.K, model.distortion
    )
    assert model.project(point) == pytest.approx(found.reshape(1, 2))


@pytest.mark.parametrize("k1", [-0.1, -0.25, -0.4])
def test_one_coefficient_folds_where_its_derivative_is_zero(k1: float) -> None:
    assert fold_radius(np.array([k1, 0.0, 0.0, 0.0]), "brown") == pytest.approx(1.0 / math.sqrt(-3.0 * k1))


@pytest.mark.parametrize(
    ("lens", "distortion"), [*LENSES, ("brown", [-0.3, 0.0, 0.0, 0.0]), ("fisheye", [-0.2] * 4)]
)
def test_distance_in_the_picture_grows_up_to_the_fold(lens: Any, distortion: list[float]) -> None:
    model, fold = camera(lens, distortion), fold_radius(np.array(distortion), lens)
    radii = np.linspace(0.0, min(0.999 * fold, 5.0), 200)
    free = model._replace(distortion=np.array([*distortion[:2], 0.0, 0.0, *distortion[4:]]))  # radial alone
    if lens == "fisheye":
        free = model
    pixels = free.project(np.column_stack([radii, np.zeros(200), np.ones(200)]))[:, 0]
    assert (np.diff(pixels) > 0.0).all()
    if fold < 5.0:
        beyond = model.project(np.array([[1.001 * fold, 0.0, 1.0]]))
        assert np.isnan(beyond).all()


def test_lens_without_distortion_never_folds() -> None:
    assert fold_radius(np.zeros(5), "brown") == math.inf
    assert fold_radius(np.zeros(4), "fisheye") == math.inf


@pytest.mark.parametrize(("focal", "k1"), [(300.0, -0.25), (300.0, -0.3), (250.0, -0.3), (600.0, -0.1)])
def test_marks_beyond_the_fold_are_not_in_view(focal: float, k1: float) -> None:
    """With f = 300 px and k1 = -0.25 marks 49 to 56 degrees off the axis were said to be in view."""
    model = camera("brown", [k1, 0.0, 0.0, 0.0, 0.0], focal)
    base_T_camera = np.diag([1.0, -1.0, -1.0, 1.0])
    base_T_camera[2, 3] = 1.0  # looks down from 1 m
    places = np.arange(0.0, 1.8, 0.05)
    seen = wholly_in_view(model, base_T_camera, Kind(0.06, 0.0), [Pose2(x, 0.0, 0.0) for x in places])
    farthest = places[seen].max() / 0.94
    assert farthest <= fold_radius(model.distortion, "brown")
    assert seen[0]
