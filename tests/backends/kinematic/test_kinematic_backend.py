from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import apply, inverse, transform
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.landmarks.tag_reader import read_tags

from .conftest import Make


def run(backend: Any, periods: int, speed: float = 0.0, turn_rate: float = 0.0) -> None:
    for _ in range(periods):
        backend.get(Base).drive(speed, turn_rate)
        backend.step()


def test_a_drive_is_nearly_what_the_encoders_say(make: Make) -> None:
    backend = make()
    start = backend.scene.base
    run(backend, 20, speed=-0.3)
    travel = backend.get(Base).wheel_travel()
    assert travel[:2] == pytest.approx((-0.3, -0.3))
    moved = start.distance(backend.scene.base)
    assert moved == pytest.approx(0.3, rel=0.02)
    assert moved != pytest.approx(0.3, rel=1e-5)


def test_a_command_that_is_not_renewed_lives_one_period(make: Make) -> None:
    backend = make()
    backend.get(Base).drive(0.3, 0.0)
    backend.step()
    there = backend.scene.base
    backend.step()
    assert backend.scene.base == there


def test_base_too_near_to_a_wall_can_leave_but_not_approach(make: Make) -> None:
    backend = make()
    scene = backend.scene
    near = scene.robot.footprint_radius_m - 0.02
    scene.move_base(Pose2(2.0, near, math.pi / 2))
    run(backend, 5, -0.2)
    assert scene.base.y == pytest.approx(near, abs=1e-9)
    run(backend, 20, 0.2)
    assert scene.base.y == pytest.approx(near + 0.2, abs=0.01)


def test_after_stop_nothing_moves(make: Make) -> None:
    backend = make()
    arm, gripper = backend.get(Arm), backend.get(Gripper)
    gripper.move(0.0)
    backend.step()
    backend.get(Base).drive(0.3, 0.0)
    arm.move(arm.command() + 0.02)
    backend.stop()
    before = (backend.scene.base, backend.scene.joints.copy(), backend.scene.width)
    for _ in range(3):
        backend.step()
    assert backend.scene.base == before[0]
    assert np.array_equal(backend.scene.joints, before[1])
    assert backend.scene.width == before[2]


@pytest.mark.parametrize("command", [(math.nan, 0.0), (0.0, math.inf), (0.7, 0.0), (0.0, -1.7)])
def test_the_base_refuses(make: Make, command: tuple[float, float]) -> None:
    with pytest.raises(CommandError):
        make().get(Base).drive(*command)


@pytest.mark.parametrize("offset", [math.nan, math.inf, 0.2, -4.0])
def test_the_arm_refuses(make: Make, offset: float) -> None:
    arm = make().get(Arm)
    with pytest.raises(CommandError):
        arm.move(arm.command() + offset)


@pytest.mark.parametrize("width", [math.nan, -0.01, 0.08])
def test_the_gripper_refuses(make: Make, width: float) -> None:
    with pytest.raises(CommandError):
        make().get(Gripper).move(width)


def test_the_base_stops_at_a_wall_while_its_wheels_go_on(make: Make) -> None:
    backend = make()
    run(backend, 100, speed=-0.5)
    assert backend.scene.base.y == pytest.approx(0.05 + 0.34, abs=3e-3)
    assert backend.get(Base).wheel_travel().left == pytest.approx(-2.5)
    assert ("base", "wall 1") in {contact[1:] for contact in backend.scene.contacts}
    run(backend, 10, speed=0.5)
    assert backend.scene.base.y > 0.5


def test_a_scan_that_is_made_later_is_the_one_of_its_period(make: Make) -> None:
    backend, asked_then = make(), make()
    later, then = [], []
    for _ in range(30):
        for item in (backend, asked_then):
            item.get(Base).drive(0.2, 0.3)
            item.step()
        later.append(backend.get(RangeSensor).scan_later())
        then.append(asked_then.get(RangeSensor).scan())
    for made, read in zip(later, then, strict=True):
        assert np.array_equal(made().ranges, read.ranges)
        assert np.array_equal(made().angles, read.angles)
    assert not np.array_equal(then[0].ranges, then[-1].ranges)


def test_a_scan_fits_the_room_and_sees_who_comes_and_goes(make: Make) -> None:
    backend = make()
    sensor = backend.get(RangeSensor)

    def beam(bearing: float) -> Any:
        scan = sensor.scan()
        world = scan.angles + backend.scene.base.theta
        nearest = np.argmin(np.abs(np.angle(np.exp(1j * (world - bearing)))))
        return scan.ranges[nearest]

    assert beam(-np.pi / 2) == pytest.approx(backend.scene.base.y - 0.05, abs=0.05)
    assert beam(np.pi / 2) == pytest.approx(2.0 - backend.scene.base.y, abs=0.05)
    assert beam(0.0) == pytest.approx(3.95 - backend.scene.base.x, abs=0.05)
    run(backend, 30)
    assert beam(0.0) == pytest.approx(3.2 - backend.scene.base.x, abs=0.05)
    run(backend, 15)
    assert beam(0.0) == pytest.approx(3.95 - backend.scene.base.x, abs=0.05)


def test_range_noise_has_the_stated_sigma(make: Make) -> None:
    backend = make()
    scans = []
    for _ in range(15):
        backend.step()
        scans.append(backend.get(RangeSensor).scan().ranges)
    assert np.std(scans, axis=0)[np.isfinite(scans[0])].mean() == pytest.approx(0.010, rel=0.1)


def drive_about(backend: Any, look: bool) -> tuple[Any, ...]:
    base, arm, gripper = backend.get(Base), backend.get(Arm), backend.get(Gripper)
    for i in range(25):
        base.drive(0.1, 0.2)
        arm.move(arm.command() + 0.002)
        gripper.move(0.03)
        if look and i % 3 == 0:
            backend.get(Camera).image()
            backend.get(RangeSensor).scan()
            arm.joints()
        backend.step()
    readings = (
        arm.joints(),
        arm.hand_force(),
        backend.get(RangeSensor).scan().ranges,
        backend.get(Camera).image(),
    )
    return backend.scene.base, *(reading.tobytes() for reading in readings)


def test_same_seed_repeats_the_run_whatever_else_is_read(make: Make) -> None:
    assert drive_about(make(3), look=False) == drive_about(make(3), look=True)


def test_another_seed_is_another_run(make: Make) -> None:
    assert drive_about(make(3), look=False)[0] != drive_about(make(4), look=False)[0]


def test_a_reading_is_taken_once_a_period(make: Make) -> None:
    backend = make()
    arm, camera = backend.get(Arm), backend.get(Camera)
    assert np.array_equal(arm.joints(), arm.joints())
    first, image = arm.joints(), camera.image()
    assert image is camera.image()
    backend.step()
    assert not np.array_equal(first, arm.joints())
    noise = camera.image().astype(float) - image
    assert noise.std() == pytest.approx(3.0 * math.sqrt(2), rel=0.1)


def test_joints_repeat_within_what_the_file_states(make: Make) -> None:
    backend = make()
    arm = backend.get(Arm)
    home, rests = arm.command(), []
    for _ in range(40):
        arm.move(home + 0.01)
        backend.step()
        arm.move(home)
        backend.step()
        backend.step()
        rests.append(backend.scene.joints - home)
    assert np.std(rests) == pytest.approx(1.5e-4, rel=0.2)


def tag_corners(scene: Scene, accession: int) -> FloatArray:
    book = scene.of(BookProps).books[accession]
    middle, half = book.height - 0.014, 0.005
    corners = [
        (0, half, middle + half),
        (0, -half, middle + half),
        (0, -half, middle - half),
        (0, half, middle - half),
    ]
    return apply(book.pose, np.array(corners))


def test_the_picture_shows_a_tag_where_the_camera_model_puts_it(make: Make) -> None:
    """Sub-pixel corners in pictures from several places, less their noise, have no common offset."""
    backend = make()
    camera, scene = backend.get(Camera), backend.scene
    optical = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
    renderer, errors = camera._renderer, []
    for y in (-0.08, -0.04, 0.0, 0.04, 0.08):
        pose = (
            scene.of(BookProps).shelves["shelf_1"].pose
            @ transform((-0.2, y, 0.19), (0.0, 0.0, 0.1))
            @ optical
        )
        picture = renderer.render(scene, pose, 1)
        for tag in read_tags(picture):
            expected = camera.model.project(apply(inverse(pose), tag_corners(scene, tag.id)))
            start = expected.astype(np.float32).copy()
            found = cv2.cornerSubPix(picture, start, (3, 3), (-1, -1), (3, 50, 1e-3))
            errors.append(found - expected)
    assert len(errors) >= 8
    assert np.abs(np.mean(errors, axis=(0, 1))).max() < 0.05
    assert np.abs(np.mean(errors, axis=1)).max() < 0.2


def test_the_tray_book_is_set_down_near_its_place_and_rides_along(make: Make) -> None:
    backend = make()
    before = inverse(backend.scene.world_T_base) @ backend.scene.of(BookProps).book_pose(117)
    assert before[:3, 3] == pytest.approx((0.10, 0.0, 0.62), abs=0.01)
    run(backend, 10, speed=-0.2, turn_rate=0.5)
    after = inverse(backend.scene.world_T_base) @ backend.scene.of(BookProps).book_pose(117)
    assert np.allclose(before, after)


def test_the_start_is_near_what_the_file_states(make: Make) -> None:
    places = [make(seed).scene.base for seed in range(5)]
    assert all(place.distance(Pose2(2.0, 1.2, 0.0)) < 0.08 for place in places)
    assert len(set(places)) == 5


def test_what_takes_an_engine_is_told_before_a_run() -> None:
    asked = {
        "format": "handcart-world/1",
        "start": {"x_m": 0.0, "y_m": 0.0},
        "ground": {"softness_mm_per_100n": 2.0},
        "camera": "engine",
    }
    remarks = KinematicBackend(load_robot("el_verde"), world_model().model_validate(asked), 0).remarks
    assert [remark.partition(":")[0] for remark in remarks] == ["camera", "ground"]
