"""Blocks on a table and on each other, painted for these tests as flat faces seen through a real lens."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
import pytest

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.blocks.block_finder import MAX_TURN_RAD, find_block
from handcart.robotics.perception.blocks.nearest_face import nearest_face
from handcart.robotics.perception.cameras.camera_model import CameraModel

CAMERA = CameraModel(
    np.array([[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]),
    np.array([-0.28, 0.09, 0.0, 0.0, 0.0]),
    640,
    480,
)
SIZE, HEIGHT, WITHIN = (0.025, 0.080), 0.040, 0.015
GREY, TABLE, FINGER = 190, 121, 82
FINE = 6  # times finer than the image it is painted
ABOVE = 1.1  # shade of what lies level
FACES = (
    # shade, normal, and corners as signs of x and y and as shares of the height
    (1.0, (-1, 0), ((-1, -1, 0), (-1, 1, 0), (-1, 1, 1), (-1, -1, 1))),
    (0.6, (1, 0), ((1, -1, 0), (1, 1, 0), (1, 1, 1), (1, -1, 1))),
    (0.8, (0, -1), ((-1, -1, 0), (1, -1, 0), (1, -1, 1), (-1, -1, 1))),
    (0.85, (0, 1), ((-1, 1, 0), (1, 1, 0), (1, 1, 1), (-1, 1, 1))),
    (ABOVE, (0, 0), ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))),
)


class Block(NamedTuple):
    """Its top's middle is at `pose`, `top` [m] above the plane in which the block is looked for."""

    pose: Pose2
    top: float = 0.0
    size: tuple[float, float] = SIZE
    grey: int = GREY


class Painter:
    """Makes pictures; `ideal` is the size of the one that a camera without a lens would need."""

    ideal, middle = (840, 640), (419.5, 319.5)

    def __init__(self) -> None:
        columns, rows = np.meshgrid(np.arange(640.0), np.arange(480.0))
        rays = CAMERA.undistort(np.column_stack([columns.ravel(), rows.ravel()]))
        self._map = (rays * 800.0 + self.middle).astype(np.float32).reshape(480, 640, 2)

    def __call__(self, blocks: list[Block], camera_T_plane: FloatArray, seed: int) -> ByteArray:
        canvas = np.full((self.ideal[1] * FINE, self.ideal[0] * FINE), TABLE, dtype=np.uint8)
        x, y, _ = inverse(camera_T_plane)[:3, 3]
        # A lower block, or one farther to the side, never hides the other.
        for block in sorted(blocks, key=lambda b: (b.top, -math.hypot(b.pose.x - x, b.pose.y - y))):
            self._block(canvas, block, camera_T_plane)
        small = cv2.resize(canvas, self.ideal, interpolation=cv2.INTER_AREA)
        none: Any = None
        image: Any = cv2.remap(small, self._map, none, cv2.INTER_LINEAR).astype(np.float32)
        image = cv2.GaussianBlur(image, (0, 0), 0.7)
        rng = np.random.default_rng(seed)
        bearing = rng.uniform(-np.pi, np.pi)
        down, across = np.mgrid[-0.5:0.5:480j, -0.5:0.5:640j]
        image = image * (1.0 + 0.25 * (math.sin(bearing) * down + math.cos(bearing) * across))
        image = np.rint(image + rng.normal(0.0, 3.0, image.shape))
        taken: ByteArray = np.clip(image, 0, 255).astype(np.uint8)
        return taken

    def _block(self, canvas: ByteArray, block: Block, camera_T_plane: FloatArray) -> None:
        camera_T_top = camera_T_plane @ block.pose.lift(block.top)
        half = np.array([block.size[0] / 2, block.size[1] / 2, -HEIGHT])
        for shade, normal, signs in FACES:
            points = (np.array(signs) * half) @ camera_T_top[:3, :3].T + camera_T_top[:3, 3]
            if shade != ABOVE and points[0] @ camera_T_top[:3, :2] @ np.array(normal) >= 0.0:
                continue
            pixels = (points[:, :2] / points[:, 2:] * 800.0 + self.middle + 0.5) * FINE - 0.5
            cv2.fillPoly(
                canvas, [np.rint(pixels * 16).astype(np.int32)], round(block.grey * shade), cv2.LINE_8, 4
            )


@pytest.fixture(scope="module")
def paint() -> Painter:
    return Painter()


def looking(
    x: float, y: float, height: float, turn: float = 0.0, tilt: tuple[float, float] = (0.0, 0.0)
) -> Transform:
    """camera_T_plane of a camera at (x, y, height) of the plane that looks down."""
    return inverse(transform((x, y, height), (math.pi, 0.0, turn)) @ transform(rpy=(*tilt, 0.0)))


class View(NamedTuple):
    """A block somewhere in the picture, the camera beside it, and where the block is said to be."""

    camera_T_plane: FloatArray
    block: Pose2
    expected: Pose2


def view(seed: int, beside: float, bearing: float | None = None, tilt: float = 0.0) -> View:
    """The camera's axis is `beside` [m] off: in any direction, or at `bearing` [rad] of the block's frame."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.5, 0.5, 2)
    block = Pose2(x, y, rng.uniform(-np.pi, np.pi))
    bearing = rng.uniform(-np.pi, np.pi) if bearing is None else bearing
    eye = block.compose(Pose2(beside * math.cos(bearing), beside * math.sin(bearing), 0.0))
    # The block lies towards the image's left or right, where there is most space.
    turn = block.theta + bearing + rng.uniform(-0.3, 0.3) + rng.integers(0, 2) * np.pi
    pose = looking(eye.x, eye.y, rng.uniform(0.27, 0.35), turn, tuple(rng.uniform(-tilt, tilt, 2)))
    x, y = rng.uniform(-0.01, 0.01, 2)
    off = Pose2(x, y, rng.uniform(-0.3, 0.3))
    return View(pose, block, block.compose(off))


def at(
    seen: View,
    x: float,
    y: float,
    theta: float = 0.0,
    top: float = 0.0,
    size: tuple[float, float] = SIZE,
    grey: int = GREY,
) -> Block:
    """A block in the frame of the one that is looked for."""
    return Block(seen.block.compose(Pose2(x, y, theta)), top, size, grey)


def alone(seen: View) -> list[Block]:
    return [Block(seen.block)]


def among_others(seen: View) -> list[Block]:
    return [Block(seen.block), *neighbours(seen)]


def neighbours(seen: View) -> list[Block]:
    """10 to 25 mm away."""
    return [
        at(seen, 0.035, 0.015),
        at(seen, -0.045, -0.02, 0.05),
        at(seen, 0.004, 0.095),
        at(seen, 0.0, -0.105),
    ]


def on_two(seen: View) -> list[Block]:
    """A block in the second layer of a wall."""
    return [Block(seen.block), *joint(seen)]


def joint(seen: View) -> list[Block]:
    """The two below it."""
    return [at(seen, 0.0, 0.0425, top=-HEIGHT), at(seen, 0.0, -0.0425, top=-HEIGHT)]


def errors(paint: Painter, seen: View, blocks: list[Block], seed: int) -> tuple[float, float]:
    """Return the error of the middle in [m], and of the heading in [rad]."""
    image = paint(blocks, seen.camera_T_plane, seed)
    found = find_block(image, CAMERA, seen.camera_T_plane, SIZE, seen.expected, WITHIN)
    assert found is not None
    return found.distance(seen.block), found.turn(seen.block)


@pytest.mark.parametrize("beside", [0.0, 0.02, 0.04, 0.06])
@pytest.mark.parametrize("blocks", [alone, among_others])
def test_middle_and_heading(paint: Painter, blocks: Callable[[View], list[Block]], beside: float) -> None:
    measured = []
    for seed in range(8):
        seen = view(seed, beside)
        measured.append(errors(paint, seen, blocks(seen), seed))
    middle, heading = np.array(measured).T
    assert np.sqrt(np.mean(middle**2)) < 6e-5
    assert middle.max() < 1.5e-4
    assert heading.max() < 2e-3


@pytest.mark.parametrize("bearing", [0.0, math.pi])
@pytest.mark.parametrize("seed", range(4))
def test_from_far_beside(paint: Painter, bearing: float, seed: int) -> None:
    seen = view(seed, 0.09, bearing)
    middle, heading = errors(paint, seen, among_others(seen), seed)
    assert middle < 1.5e-4
    assert heading < 2e-3


@pytest.mark.parametrize("seed", range(8))
def test_in_a_wall_three_edges_are_enough(paint: Painter, seed: int) -> None:
    seen = view(seed, 0.06, (-1) ** seed * math.pi / 2)
    middle, heading = errors(paint, seen, on_two(seen), seed)
    assert middle < 2e-4
    assert heading < 2e-3


def test_in_a_wall_from_straight_above_its_ends_are_not_to_be_seen(paint: Painter) -> None:
    for seed in range(4):
        seen = view(seed, 0.0)
        image = paint(on_two(seen), seen.camera_T_plane, seed)
        assert find_block(image, CAMERA, seen.camera_T_plane, SIZE, seen.expected, WITHIN) is None


@pytest.mark.parametrize("seed", range(6))
def test_with_a_camera_that_is_tilted(paint: Painter, seed: int) -> None:
    seen = view(seed, 0.03, tilt=0.12)
    middle, heading = errors(paint, seen, among_others(seen), seed)
    assert middle < 1.5e-4
    assert heading < 2e-3


@pytest.mark.parametrize(("size", "grey"), [((0.03, 0.06), 190), ((0.08, 0.025), 150), ((0.04, 0.04), 230)])
def test_of_another_size_and_shade(paint: Painter, size: tuple[float, float], grey: int) -> None:
    seen = view(2, 0.03)
    image = paint([at(seen, 0.0, 0.0, size=size, grey=grey)], seen.camera_T_plane, 1)
    found = find_block(image, CAMERA, seen.camera_T_plane, size, seen.expected, WITHIN)
    assert found is not None
    assert found.distance(seen.block) < 1.5e-4
    assert find_block(image, CAMERA, seen.camera_T_plane, SIZE, seen.expected, WITHIN) is None


def test_the_nearest_of_two_that_are_near(paint: Painter) -> None:
    seen = view(3, 0.02)
    image = paint([at(seen, -0.018, 0.0), at(seen, 0.018, 0.0)], seen.camera_T_plane, 1)
    for x in (-0.018, 0.018):
        expected = seen.block.compose(Pose2(x / 2, 0.0, 0.1))
        found = find_block(image, CAMERA, seen.camera_T_plane, SIZE, expected, 0.03)
        assert found is not None
        assert found.relative_to(seen.block) == pytest.approx((x, 0.0, 0.0), abs=2e-3)


OTHERS: dict[str, Callable[[View], list[Block]]] = {
    "nothing": lambda seen: [],
    "its neighbours": neighbours,
    "the two below it": joint,
    "one below it, alike": lambda seen: [at(seen, 0.0, 0.0, top=-HEIGHT)],
    "its place in a wall": lambda seen: [*joint(seen), at(seen, 0.0, 0.085), at(seen, 0.0, -0.085)],
    "a lower one": lambda seen: [at(seen, 0.0, 0.0, top=-0.02)],
    "a higher one": lambda seen: [at(seen, 0.0, 0.0, top=0.02)],
    "one held above it": lambda seen: [at(seen, 0.0, 0.0, top=0.06)],
    "a wider one": lambda seen: [at(seen, 0.0, 0.0, size=(0.028, 0.08))],
    "a narrower one": lambda seen: [at(seen, 0.0, 0.0, size=(0.022, 0.08))],
    "a shorter one": lambda seen: [at(seen, 0.0, 0.0, size=(0.025, 0.072))],
    "a longer one": lambda seen: [at(seen, 0.0, 0.0, size=(0.025, 0.09))],
    "a board": lambda seen: [at(seen, 0.0, 0.0, size=(0.1, 0.16))],
    "a bar": lambda seen: [at(seen, 0.0, 0.0, size=(0.025, 0.3))],
    "a square": lambda seen: [at(seen, 0.0, 0.0, size=(0.06, 0.06))],
    "one across": lambda seen: [at(seen, 0.0, 0.0, np.pi / 2)],
    "a dark one": lambda seen: [at(seen, 0.0, 0.0, grey=80)],
    "two side by side": lambda seen: [at(seen, -0.0125, 0.0), at(seen, 0.0125, 0.0)],
    "two end to end": lambda seen: [at(seen, 0.0, -0.04), at(seen, 0.0, 0.04)],
    "a gap": lambda seen: [at(seen, -0.025, 0.0), at(seen, 0.025, 0.0)],
    "fingers": lambda seen: [
        at(seen, 0.0, y, top=0.03, size=(0.02, 0.01), grey=FINGER) for y in (-0.02, 0.02)
    ],
    "a covered one": lambda seen: [
        Block(seen.block),
        at(seen, 0.0, 0.03, 0.2, top=0.03, size=(0.04, 0.04), grey=FINGER),
    ],
}


@pytest.mark.parametrize("name", OTHERS)
def test_nothing_else_is_taken_for_it(paint: Painter, name: str) -> None:
    for seed in range(6):
        seen = view(seed, 0.012 * seed)
        image = paint(OTHERS[name](seen), seen.camera_T_plane, seed)
        assert find_block(image, CAMERA, seen.camera_T_plane, SIZE, seen.expected, 0.012) is None


def test_no_find_in_noise() -> None:
    rng = np.random.default_rng(1)
    for image in (np.zeros((480, 640)), rng.integers(0, 256, (480, 640)), np.full((480, 640), 255)):
        pose = looking(0.0, 0.0, 0.3)
        assert find_block(image.astype(np.uint8), CAMERA, pose, SIZE, Pose2(0.0, 0.0, 0.0), WITHIN) is None


def test_only_near_the_expected_place_and_heading(paint: Painter) -> None:
    seen = view(4, 0.03)
    image = paint([Block(seen.block)], seen.camera_T_plane, 1)

    def found(x: float, theta: float, within: float) -> bool:
        expected = seen.block.compose(Pose2(x, 0.0, theta))
        return find_block(image, CAMERA, seen.camera_T_plane, SIZE, expected, within) is not None

    assert found(0.0095, 0.0, 0.010) and not found(0.0105, 0.0, 0.010)
    assert found(0.025, 0.0, 0.030) and found(0.0, 0.0, 0.001)
    assert found(0.0, MAX_TURN_RAD - 0.01, 0.010) and not found(0.0, MAX_TURN_RAD + 0.01, 0.010)
    assert not found(0.2, 0.0, 0.010)


def test_half_out_of_view_is_not_found(paint: Painter) -> None:
    pose = looking(0.0, 0.0, 0.3)
    for x in (0.118, 0.125, 0.14):
        block = Pose2(x, 0.0, 0.1)
        assert find_block(paint([Block(block)], pose, 1), CAMERA, pose, SIZE, block, WITHIN) is None


def test_a_plane_behind_the_camera_is_an_error() -> None:
    image = np.zeros((480, 640), dtype=np.uint8)
    with pytest.raises(ValueError, match="before the camera"):
        find_block(image, CAMERA, looking(0.0, 0.0, -0.3), SIZE, Pose2(0.0, 0.0, 0.0), WITHIN)


def test_a_face_that_is_too_small_is_an_error() -> None:
    image = np.zeros((480, 640), dtype=np.uint8)
    with pytest.raises(ValueError, match=r"0\.01 x 0\.08 m is too small; allowed: 0\.015 m or more"):
        find_block(image, CAMERA, looking(0.0, 0.0, 0.3), (0.01, 0.08), Pose2(0.0, 0.0, 0.0), WITHIN)


@pytest.mark.parametrize("grey", [GREY, TABLE])
def test_nearest_face_reports_size_and_offset_of_a_bright_block(grey: int) -> None:
    above = transform((0.0, 0.0, 0.3), (math.pi, 0.0, 0.0))
    block = Block(Pose2(0.02, -0.01, 0.6), size=(0.03, 0.06), grey=grey)
    image = Painter()([block], inverse(above), seed=4)
    found = nearest_face(image, CAMERA, inverse(above), Pose2(0.0, 0.0, 0.1))
    if grey == TABLE:
        assert found is None or found.long_side < 0.05
        return
    assert found is not None
    assert (found.long_side, found.short_side) == pytest.approx((0.06, 0.03), abs=0.004)
    assert found.distance == pytest.approx(math.hypot(0.02, 0.01), abs=0.004)
    assert math.remainder(found.direction - (0.5 + math.pi / 2), math.pi) == pytest.approx(0.0, abs=0.06)
