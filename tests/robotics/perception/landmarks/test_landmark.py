from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.geometry.transform import transform
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.landmarks.landmark import INK, PAPER, diagonals_meet, draw_landmark
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_pose import (
    facing,
    planar_pose,
)

from ..conftest import Tabletop

HEIGHT = 0.3


def seen_at(
    tabletop: Tabletop, pose: Pose2, seed: int, height: float = HEIGHT, grey: float = 150.0
) -> ByteArray:
    """The image of a landmark that lies at `pose` of a plane that the camera faces."""
    table = tabletop.table(grey)
    tabletop.put(table, draw_landmark(), 0.0, 0.0)
    return tabletop.photograph(table, facing(height) @ pose.lift(), seed)


def errors(tabletop: Tabletop, pose: Pose2, seed: int) -> tuple[float, float]:
    """Return the error of the centre in [m] and of the angle in [rad]."""
    (seen,) = find_landmarks(seen_at(tabletop, pose, seed), tabletop.camera)
    found = planar_pose(seen, facing(HEIGHT))
    return found.distance(pose), found.turn(pose)


def random_poses(offset: float, count: int, seed: int) -> list[Pose2]:
    """Any heading, `offset` [m] from the middle, towards the image's left or right."""
    rng = np.random.default_rng(seed)
    bearings = rng.uniform(-0.3, 0.3, count) + rng.integers(0, 2, count) * np.pi
    return [
        Pose2(offset * math.cos(bearing), offset * math.sin(bearing), wrap(turn))
        for bearing, turn in zip(bearings, rng.uniform(-np.pi, np.pi, count), strict=True)
    ]


@pytest.mark.parametrize(("offset", "limit"), [(0.0007, 2e-5), (0.03, 5e-5), (0.06, 1.3e-4)])
def test_centre_and_angle(tabletop: Tabletop, offset: float, limit: float) -> None:
    measured = np.array(
        [errors(tabletop, pose, seed) for seed, pose in enumerate(random_poses(offset, 12, 1))]
    )
    assert measured[:, 0].max() < limit
    assert measured[:, 1].max() < 3e-4


def test_without_the_lens_it_is_off_at_the_rim(tabletop: Tabletop) -> None:
    pose = Pose2(0.06, 0.0, 0.4)
    plain = tabletop.camera._replace(distortion=np.zeros(5))
    (seen,) = find_landmarks(seen_at(tabletop, pose, 1), plain)
    assert 3e-4 < planar_pose(seen, facing(HEIGHT)).distance(pose) < 5e-3


@pytest.mark.parametrize("turn", np.linspace(-3.1, 3.1, 13))
def test_direction_is_told_over_the_full_turn(tabletop: Tabletop, turn: float) -> None:
    (seen,) = find_landmarks(seen_at(tabletop, Pose2(0.01, -0.01, turn), 3), tabletop.camera)
    assert planar_pose(seen, facing(HEIGHT)).theta == pytest.approx(turn, abs=1e-3)
    assert wrap(seen.angle + turn) == pytest.approx(0.0, abs=1e-3)
    assert seen.centre == pytest.approx(diagonals_meet(seen.corners), abs=0.2)


@pytest.mark.parametrize("height", [0.17, 0.2, 0.4, 0.6, 0.8])
@pytest.mark.parametrize("grey", [15, 90, 235])
def test_found_near_and_far_on_any_table(tabletop: Tabletop, height: float, grey: int) -> None:
    pose = Pose2(0.004, 0.002, 0.7)
    (seen,) = find_landmarks(seen_at(tabletop, pose, 4, height, grey), tabletop.camera)
    assert planar_pose(seen, facing(height)).distance(pose) < 1e-4


@pytest.mark.parametrize("seed", range(6))
def test_pose_in_space_and_on_a_tilted_plane(tabletop: Tabletop, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tilt = transform(rpy=(*rng.uniform(-0.25, 0.25, 2), 0.0))
    camera_T_plane = facing(HEIGHT) @ tilt
    x, y = rng.uniform(-0.01, 0.01, 2)
    pose = Pose2(x, y, rng.uniform(-3, 3))
    table = tabletop.table(seed=seed)
    tabletop.put(table, draw_landmark(), 0.0, 0.0)
    image = tabletop.photograph(table, camera_T_plane @ pose.lift(), seed)
    (seen,) = find_landmarks(image, tabletop.camera)
    found = planar_pose(seen, camera_T_plane)
    assert found.distance(pose) < 4e-5
    assert found.turn(pose) < 3e-4


def ink(side: float) -> np.ndarray:
    fields = round(side / 1.25e-4)
    return np.full((fields, fields), INK, dtype=np.uint8)


def white(picture: np.ndarray, top: float, left: float, bottom: float, right: float) -> np.ndarray:
    """The picture with a white field, its ends as shares of the sides."""
    height, width = picture.shape
    picture[round(top * height) : round(bottom * height), round(left * width) : round(right * width)] = PAPER
    return picture


def disc() -> np.ndarray:
    picture = np.full((480, 480), PAPER, dtype=np.uint8)
    cv2.circle(picture, (240, 240), 240, (INK,), cv2.FILLED)
    return white(picture, 0.2, 0.2, 0.4, 0.4)


def tag(number: int) -> np.ndarray:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.generateImageMarker(dictionary, number, 480)


OTHERS = {
    "a full square": ink(0.06),
    "a frame": white(ink(0.06), 0.125, 0.125, 0.875, 0.875),
    "a white field in the middle": white(ink(0.06), 0.375, 0.375, 0.625, 0.625),
    "a larger white field": white(ink(0.06), 0.125, 0.125, 0.5, 0.5),
    "two white fields": white(white(ink(0.06), 0.125, 0.125, 0.375, 0.375), 0.625, 0.625, 0.875, 0.875),
    "a white field at the rim": white(ink(0.06), 0.0, 0.0, 0.25, 0.25),
    "a disc": disc(),
    "a rectangle with the field": cv2.resize(white(ink(0.06), 0.125, 0.125, 0.375, 0.375), (400, 480)),
    "a slightly long rectangle": cv2.resize(white(ink(0.06), 0.125, 0.125, 0.375, 0.375), (450, 480)),
    "a rhomb": cv2.warpAffine(
        white(ink(0.06), 0.125, 0.125, 0.375, 0.375),
        np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0]]),
        (540, 480),
        borderValue=(PAPER,),
    ),
    "the top of a dark block": np.full((640, 200), 60, dtype=np.uint8),
    "the landmark in white on black": 255 - draw_landmark(margin=0.0),
    **{f"tag {number}": tag(number) for number in (0, 1, 17)},
}


@pytest.mark.parametrize("name", OTHERS)
def test_another_mark_is_not_taken_for_it(tabletop: Tabletop, name: str) -> None:
    other = np.pad(OTHERS[name], 80, constant_values=PAPER)
    for seed, turn in enumerate((0.1, 2.0)):
        table = tabletop.table()
        tabletop.put(table, other, -0.05, 0.0)
        camera_T_table = facing(0.4) @ Pose2(0.0, 0.0, turn).lift()
        assert find_landmarks(tabletop.photograph(table, camera_T_table, seed), tabletop.camera) == []
        tabletop.put(table, draw_landmark(), 0.05, 0.0)
        (seen,) = find_landmarks(tabletop.photograph(table, camera_T_table, seed), tabletop.camera)
        assert planar_pose(seen, camera_T_table) == pytest.approx((0.05, 0.0, 0.0), abs=1e-3)


def test_no_tag_is_taken_for_it(tabletop: Tabletop) -> None:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
    for first in range(0, 48, 9):
        table = tabletop.table(230)
        for i in range(9):
            marker = cv2.aruco.generateImageMarker(dictionary, first + i, 280)
            tabletop.put(table, marker, 0.05 * (i % 3 - 1), 0.05 * (i // 3 - 1))
        assert find_landmarks(tabletop.photograph(table, facing(HEIGHT), first), tabletop.camera) == []


def test_a_square_of_another_size_is_told_by_its_distance(tabletop: Tabletop) -> None:
    table = tabletop.table()
    tabletop.put(table, draw_landmark(0.048), 0.0, 0.0)
    image = tabletop.photograph(table, facing(HEIGHT), 1)
    assert len(find_landmarks(image, tabletop.camera)) == 1
    assert find_landmarks(image, tabletop.camera, distances=(0.27, 0.33)) == []
    assert len(find_landmarks(image, tabletop.camera, 0.048, (0.27, 0.33))) == 1


def test_two_of_them_come_in_order(tabletop: Tabletop) -> None:
    table = tabletop.table(seed=5)
    for x in (-0.06, 0.04):
        tabletop.put(table, draw_landmark(), x, 0.0)
    seen = find_landmarks(tabletop.photograph(table, facing(HEIGHT), 1), tabletop.camera)
    assert [planar_pose(landmark, facing(HEIGHT)).x for landmark in seen] == pytest.approx(
        [0.04, -0.06], abs=1e-4
    )


def test_half_out_of_view_or_covered_is_not_seen(tabletop: Tabletop) -> None:
    assert find_landmarks(seen_at(tabletop, Pose2(0.1, 0.0, 0.2), 1), tabletop.camera) == []
    table = tabletop.table()
    tabletop.put(table, draw_landmark(), 0.0, 0.0)
    tabletop.put(table, np.full((200, 200), 90, dtype=np.uint8), 0.03, 0.0)
    assert find_landmarks(tabletop.photograph(table, facing(HEIGHT), 1), tabletop.camera) == []


@pytest.mark.parametrize("seed", range(4))
def test_found_among_blocks(tabletop: Tabletop, seed: int) -> None:
    rng = np.random.default_rng(seed)
    table = tabletop.table(seed=seed)
    for _ in range(14):
        block = np.full((640, 200)[:: rng.choice([-1, 1])], rng.integers(30, 220), dtype=np.uint8)
        tabletop.put(table, block, *rng.uniform(-0.1, 0.1, 2))
    tabletop.put(table, draw_landmark(), 0.02, 0.01)
    (seen,) = find_landmarks(tabletop.photograph(table, facing(HEIGHT), seed), tabletop.camera)
    assert planar_pose(seen, facing(HEIGHT)) == pytest.approx((0.02, 0.01, 0.0), abs=2e-4)


def test_nothing_in_an_empty_or_noisy_image(tabletop: Tabletop) -> None:
    rng = np.random.default_rng(1)
    for image in (np.zeros((480, 640)), rng.integers(0, 256, (480, 640)), np.full((480, 640), 255)):
        assert find_landmarks(image.astype(np.uint8), tabletop.camera) == []


def test_any_image_size(tabletop: Tabletop) -> None:
    image = seen_at(tabletop, Pose2(0.0, 0.0, 0.3), 1)
    cut = tabletop.camera._replace(width=637, height=471)
    (whole,), (part,) = find_landmarks(image, tabletop.camera), find_landmarks(image[:471, :637].copy(), cut)
    assert part.corners == pytest.approx(whole.corners, abs=0.02)
    assert find_landmarks(image[:20, :20].copy(), cut) == []


def test_a_plane_behind_the_camera_is_an_error(tabletop: Tabletop) -> None:
    (seen,) = find_landmarks(seen_at(tabletop, Pose2(0.0, 0.0, 0.0), 1), tabletop.camera)
    with pytest.raises(ValueError, match="before the camera"):
        planar_pose(seen, facing(-0.3))


def test_a_sheet_that_pixels_do_not_fit_is_an_error() -> None:
    with pytest.raises(ValueError, match="whole numbers of pixels"):
        draw_landmark(0.0601)
    sheet = draw_landmark()
    assert sheet.shape == (640, 640)
    assert (
        sheet[0, 0] == PAPER and sheet[90, 90] == INK and sheet[150, 150] == PAPER and sheet[150, 490] == INK
    )
