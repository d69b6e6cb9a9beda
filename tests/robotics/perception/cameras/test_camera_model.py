from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.perception.cameras.camera_model import picture_of_plane

from ..conftest import Bookshelf


def test_pixels_on_the_plane_go_back_and_forth(bookshelf: Bookshelf) -> None:
    camera_T_shelf = bookshelf.looking_from(0.03, rpy=(0.02, -0.03, 0.04))
    pixels = np.stack(np.meshgrid(np.linspace(0, 639, 9), np.linspace(0, 479, 7)), axis=-1).reshape(-1, 2)
    for x in (0.0, 0.05):
        points = bookshelf.camera.pixel_on_plane(pixels, camera_T_shelf, x)
        assert bookshelf.camera.plane_in_image(points, camera_T_shelf, x) == pytest.approx(pixels, abs=1e-4)


def test_y_is_to_the_left_and_z_up(bookshelf: Bookshelf) -> None:
    camera_T_shelf = bookshelf.looking_from(0.0)
    left, upper = bookshelf.camera.plane_in_image(np.array([[0.05, 0.09], [0.0, 0.12]]), camera_T_shelf)
    assert left[0] < 319 and left[1] == pytest.approx(239.5)
    assert upper[1] < 239 and upper[0] == pytest.approx(319.5)


def test_what_is_behind_is_nan(bookshelf: Bookshelf) -> None:
    assert np.isnan(bookshelf.camera.project(np.array([[0.0, 0.0, -1.0]]))).all()
    away = bookshelf.looking_from(0.0, rpy=(0, 0, np.pi))
    assert np.isnan(bookshelf.camera.pixel_on_plane(np.array([[319.5, 239.5]]), away)).all()


def test_nothing_gives_nothing(bookshelf: Bookshelf) -> None:
    assert bookshelf.camera.project(np.empty((0, 3))).shape == (0, 2)
    assert bookshelf.camera.undistort(np.empty((0, 2))).shape == (0, 2)


def test_rectified_picture_shows_points_where_they_are(bookshelf: Bookshelf) -> None:
    camera_T_shelf = bookshelf.looking_from(0.01, rpy=(0.01, 0.02, -0.02))
    image = np.zeros((480, 640), dtype=np.uint8)
    dot = np.array([[150.0, 320.0]])
    image[318:323, 148:153] = 255
    y, z = bookshelf.camera.pixel_on_plane(dot, camera_T_shelf)[0]
    homography = picture_of_plane(camera_T_shelf, (y + 0.01, z + 0.005), 0.0002)
    picture = bookshelf.camera.rectify(image, homography, (101, 51)).astype(float)
    rows, columns = np.mgrid[:51, :101]
    centre = ((picture * columns).sum() / picture.sum(), (picture * rows).sum() / picture.sum())
    assert centre == pytest.approx((50, 25), abs=0.3)
