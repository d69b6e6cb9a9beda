"""A depth camera on each simulated backend: depth, colour, errors of the file, pose and time."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from handcart.backends.backend import Backend
from handcart.backends.capabilities.depth_camera import DepthCamera, DepthImage
from handcart.backends.saved_state import pack, unpack
from handcart.backends.simulation.simulated_backend import SimulatedBackend
from handcart.robotics.numerics.arrays import BoolArray

from .conftest import DOWN, Make

STILL = ", errors: {sigma_mm: 0, sigma_mm_per_m2: 0, scale_percent: 0, dropout_percent: 0"
NOISY = "errors: {start_mm: 0, start_deg: 0}\n"


def camera_of(backend: Backend) -> DepthCamera:
    found = backend.sensor("mast")
    assert isinstance(found, DepthCamera)
    return found


def first(backend: Backend) -> DepthImage:
    backend.step()
    return camera_of(backend).image()


def readings(image: DepthImage) -> BoolArray:
    return np.isfinite(image.depth)


def test_depth_is_the_distance_of_what_is_there(make: Make, backend_name: str) -> None:
    """The box's front is at x = 2.4, the wall's at 3.95; the camera at 1.35."""
    image = first(make(backend_name))
    assert image.depth.shape == (90, 120)
    assert image.depth.dtype == np.float32
    assert image.depth[30, 60] == pytest.approx(2.4 - 1.35, abs=2e-3)
    assert image.depth[30, 5] == pytest.approx(3.95 - 1.35, abs=2e-3)


DRUM = """\
objects:
  - {name: drum, shape: cylinder, x_m: 2.1, y_m: 1.5, height_m: 0.0, size_mm: [300, 300, 600], mass_kg: 2}
"""


def test_points_on_a_cylinder_are_as_far_from_its_axis(make: Make, backend_name: str) -> None:
    """Engines draw a cylinder as strips, whose middle is 1.3 mm nearer."""
    backend = make(backend_name, tilt=DOWN, things=DRUM)
    points = first(backend).points(camera_of(backend).model) + np.array([1.0, 1.5, 0.0])
    away = np.hypot(points[:, 0] - 2.1, points[:, 1] - 1.5)
    on_side = (away < 0.17) & (points[:, 2] > 0.05) & (points[:, 2] < 0.595)
    assert on_side.sum() > 150
    assert np.abs(away[on_side] - 0.15).max() < 4e-3
    assert ((away < 0.15) & (np.abs(points[:, 2] - 0.6) < 4e-3)).sum() > 50


def test_points_lie_on_box_walls_and_floor_in_base(make: Make, backend_name: str) -> None:
    backend = make(backend_name, tilt=DOWN)
    points = first(backend).points(camera_of(backend).model)
    x, y, z = (points + np.array([1.0, 1.5, 0.0])).T
    on_box = (np.abs(x - 2.4) < 4e-3) & (np.abs(y - 1.5) < 0.26)
    on_wall = np.abs(x - 3.95) < 4e-3
    on_side = (np.abs(np.abs(y - 1.5) - 0.25) < 4e-3) & (x > 2.4) | (np.abs(np.abs(y - 1.5) - 1.45) < 4e-3)
    on_floor = np.abs(z) < 4e-3
    assert on_box.mean() > 0.1
    assert on_wall.mean() > 0.02
    assert on_floor.mean() > 0.1
    assert (on_box | on_wall | on_side | on_floor).mean() > 0.995


def test_colour_tells_box_from_wall(make: Make, backend_name: str) -> None:
    image = first(make(backend_name, camera="engine" if backend_name == "mujoco" else "scene"))
    box, wall = image.colour[30, 60].astype(int), image.colour[30, 5].astype(int)
    assert image.colour.shape == (90, 120, 3)
    assert box[2] - box[0] > 15 > 0 > wall[2] - wall[0]  # lacquer is blue, plaster yellowish


def test_nearer_than_the_minimum_range_has_no_reading(make: Make, backend_name: str) -> None:
    image = first(make(backend_name, ", range_min_m: 1.2, reach_m: 2.4"))
    assert not readings(image)[30, 60]  # the box, at 1.05 m
    assert not readings(image)[30, 5]  # the wall, at 2.6 m
    assert np.nanmin(image.depth) >= 1.2 - 1e-6
    assert np.nanmax(image.depth) <= 2.4 + 1e-6


@pytest.mark.parametrize("edge_px", [1, 4])
def test_pixels_at_a_step_in_depth_drop_out(make: Make, backend_name: str, edge_px: int) -> None:
    row = readings(first(make(backend_name, f"{STILL}, edge_px: {edge_px}}}", NOISY)))[20]
    assert row[60]
    assert row[5]
    lost = np.flatnonzero(~row)
    assert len(lost) == 2 * 2 * edge_px  # each of the box's two sides, on both of its own sides
    assert np.diff(lost).max() > 30


def test_surfaces_at_a_grazing_angle_drop_out(make: Make, backend_name: str) -> None:
    """Cosine between ray and normal of the floor, by the geometry of a column beside the box."""
    image = first(make(backend_name, f"{STILL}, edge_px: 0, grazing_deg: 60}}", NOISY, tilt=DOWN))
    column, rows = 8, np.arange(90)
    x, y, down = (column - 59.5) / 100.0, (rows - 44.5) / 100.0, -DOWN - np.pi / 2
    cosine = (np.sin(down) + y * np.cos(down)) / np.sqrt(1.0 + x**2 + y**2)
    row = readings(image)[:, column]
    assert row[cosine > 0.52].all()
    flat = (cosine < 0.48) & (rows > 40)
    assert flat.sum() > 5
    assert not row[flat].any()
    assert row[:30].all()  # the wall is seen from ahead


def test_noise_is_that_of_the_file_and_grows(make: Make, backend_name: str) -> None:
    growing = "sigma_mm: 2, sigma_mm_per_m2: 6, sigma_from_m: 0.05"
    keys = f", errors: {{{growing}, scale_percent: 0, dropout_percent: 10}}"
    noisy = first(make(backend_name, keys, NOISY)).depth
    true = first(make(backend_name, errors=NOISY.replace("}", ", none: true}"))).depth
    off = 1e3 * (noisy - true)
    for area, distance in ((np.s_[12:40, 52:68], 1.05), (np.s_[12:40, 2:20], 2.6)):
        sigma = 2.0 + 6.0 * (distance - 0.05) ** 2
        assert np.nanstd(off[area]) == pytest.approx(sigma, rel=0.15)
        assert np.isnan(off[area]).mean() == pytest.approx(0.10, abs=0.04)


def test_scale_is_drawn_once_by_the_seed(make: Make) -> None:
    keys = ", errors: {sigma_mm: 0, sigma_mm_per_m2: 0, scale_percent: 3, dropout_percent: 0}"
    depths = [float(first(make("kinematic", keys, NOISY, seed=seed)).depth[30, 60]) for seed in (1, 1, 2)]
    assert depths[0] == depths[1]
    assert abs(depths[0] - depths[2]) > 1e-3
    assert max(abs(depth - 1.05) for depth in depths) < 0.15


def test_picture_is_one_a_period_and_new_in_the_next(make: Make, backend_name: str) -> None:
    backend = make(backend_name, errors=NOISY)
    image = first(backend)
    assert camera_of(backend).image() is image
    later = first(backend)
    assert later.time - image.time == pytest.approx(backend.period)
    assert not np.array_equal(later.depth, image.depth, equal_nan=True)


def test_restored_backend_takes_the_same_picture(make: Make, backend_name: str) -> None:
    backend = make(backend_name, errors=NOISY)
    first(backend)
    kept = pack(backend.state())
    expected = first(backend)
    again = make(backend_name, errors=NOISY)
    again.set_state(unpack(kept))
    image = first(again)
    assert image.time == expected.time
    share = float((readings(image) == readings(expected)).mean())
    if backend_name == "pybullet":  # its last digits may differ
        assert share > 0.99
    else:
        assert np.array_equal(image.depth, expected.depth, equal_nan=True)
        assert np.array_equal(image.colour, expected.colour)


@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_engines_renderer_and_rays_agree(make: Make, name: str) -> None:
    """Two ways to depth that share nothing but the world: a fault of one of them would show."""
    if name == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    depths = []
    for camera in ("scene", "engine"):
        backend = make(name, tilt=DOWN, camera=camera)
        depths.append(first(backend).depth)
    off = np.abs(depths[0] - depths[1])
    assert np.isfinite(off).mean() > 0.9
    assert np.nanmedian(off) < 1e-3
    assert np.nanmean(off > 0.015) < 0.03  # Bullet's plane is drawn 5 mm low


def test_second_camera_has_noise_of_its_own(make: Make) -> None:
    """Two depth cameras at one place: their errors are drawn by their names."""
    backend = cast("SimulatedBackend", make("kinematic", errors=NOISY))
    robot = backend._robot
    twin = robot.with_sensors({"twin": robot.sensors["mast"].model_copy(update={"frame": "mast"})})
    both = type(backend)(twin, backend._world_file, 3)
    both.step()
    one, other = (both.sensor(name) for name in ("mast", "twin"))
    assert isinstance(one, DepthCamera)
    assert isinstance(other, DepthCamera)
    images = one.image(), other.image()
    assert np.allclose(images[0].base_T_camera, images[1].base_T_camera)
    assert not np.array_equal(images[0].depth, images[1].depth, equal_nan=True)
    backend.step()
    alone = backend.sensor("mast")
    assert isinstance(alone, DepthCamera)
    assert np.array_equal(alone.image().depth, images[0].depth, equal_nan=True)
