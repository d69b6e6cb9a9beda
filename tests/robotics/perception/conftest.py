"""A small renderer for tests: a row of spines, their sides and a dark shelf, seen through a real lens."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np
import pytest

from handcart.backends.simulation.books.textures import draw_spine
from handcart.robotics.geometry.transform import transform
from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.cameras.camera_model import CameraModel, plane_to_rays

CAMERA = CameraModel(
    np.array([[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]),
    np.array([-0.28, 0.09, 0.0, 0.0, 0.0]),
    640,
    480,
)
SHELF_LOOK = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # camera_R_shelf, straight on
DEPTH, SUPERSAMPLE = 0.14, 2


class Book(NamedTuple):
    left: float
    thickness: float
    height: float
    proud: float
    grey: int
    text: str | None
    font: str
    tag: int | None = None
    smear: bool = False
    seed: int = 0

    @property
    def right(self) -> float:
        return self.left - self.thickness


def looking_from(y: float, z: float = 0.09, distance: float = 0.3, rpy: tuple[float, ...] = (0, 0, 0)) -> Any:
    """camera_T_shelf of a camera at (−distance, y, z) of the shelf frame that looks into the shelf."""
    shelf_T_camera = np.eye(4)
    shelf_T_camera[:3, :3] = transform((0, 0, 0), rpy)[:3, :3] @ SHELF_LOOK.T
    shelf_T_camera[:3, 3] = -distance, y, z
    return np.linalg.inv(shelf_T_camera)


def render(books: list[Book], camera_T_shelf: Any, seed: int, noise: float = 3.0, blur: float = 0.7) -> Any:
    """The image (480, 640) uint8: blur in [px], noise in grey levels, a light gradient from the seed."""
    rng = np.random.default_rng(seed)
    ideal_K = np.array([[800.0, 0.0, 419.5], [0.0, 800.0, 319.5], [0.0, 0.0, 1.0]])
    scale = np.diag([SUPERSAMPLE, SUPERSAMPLE, 1.0])
    scale[:2, 2] = (SUPERSAMPLE - 1) / 2
    K = scale @ ideal_K
    size = (840 * SUPERSAMPLE, 640 * SUPERSAMPLE)
    canvas = np.full(size[::-1], 16.0, dtype=np.float32)
    _board(canvas, K, camera_T_shelf)
    eye_y = np.linalg.inv(camera_T_shelf)[1, 3]
    # Painter's order: surfaces farther back or farther from the optical axis come first.
    # nearer.
    for book in sorted(books, key=lambda b: (-round(b.proud, 6), -abs((b.left + b.right) / 2 - eye_y))):
        _side(canvas, K, camera_T_shelf, book, eye_y)
    for book in sorted(books, key=lambda b: -b.proud):
        _spine(canvas, K, camera_T_shelf, book)
    return _photograph(canvas, ideal_K, rng, noise, blur)


def _photograph(canvas: Any, ideal_K: Any, rng: Any, noise: float, blur: float) -> ByteArray:
    small = cv2.resize(canvas, (840, 640), interpolation=cv2.INTER_AREA)
    pixels = np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1).reshape(-1, 2)
    rays = CAMERA.undistort(pixels)
    source = (rays * 800.0 + ideal_K[:2, 2]).astype(np.float32).reshape(480, 640, 2)
    image: Any = cv2.remap(small, source[..., 0], source[..., 1], cv2.INTER_CUBIC)
    image = cv2.GaussianBlur(image, (0, 0), blur)
    angle, depth = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.2)
    v, u = np.mgrid[-1:1:480j, -1:1:640j]
    image *= (0.92 + depth * (np.cos(angle) * u + np.sin(angle) * v)).astype(np.float32)
    image += rng.normal(0.0, noise, image.shape).astype(np.float32)
    taken: ByteArray = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return taken


def _paint(canvas: Any, homography: Any, texture: Any) -> None:
    size = canvas.shape[::-1]
    warped = cv2.warpPerspective(texture.astype(np.float32), homography, size, flags=cv2.INTER_AREA)
    cover = cv2.warpPerspective(np.ones(texture.shape, np.float32), homography, size, flags=cv2.INTER_LINEAR)
    np.copyto(canvas, warped * cover + canvas * (1 - cover))


def _spine(canvas: Any, K: Any, camera_T_shelf: Any, book: Book) -> None:
    texture: Any = draw_spine(
        book.thickness * 1e3,
        book.height * 1e3,
        book.grey,
        book.tag,
        book.text,
        book.font,
        8,
        book.smear,
        book.seed,
    )
    texture = cv2.resize(texture, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
    m = book.height / texture.shape[0]
    n = book.thickness / texture.shape[1]
    pixel_to_plane = np.array([[-n, 0, book.left - n / 2], [0, -m, book.height - m / 2], [0, 0, 1]])
    _paint(canvas, K @ plane_to_rays(camera_T_shelf, book.proud) @ pixel_to_plane, texture)


def _side(canvas: Any, K: Any, camera_T_shelf: Any, book: Book, eye_y: float) -> None:
    y = book.left if eye_y > book.left else book.right
    if book.right < eye_y < book.left:
        return
    corners = [
        (book.proud + dx, y, z) for dx, z in ((0, 0), (DEPTH, 0), (DEPTH, book.height), (0, book.height))
    ]
    shade = 0.3 * book.grey
    _polygon(canvas, K, camera_T_shelf, corners, shade)


def _board(canvas: Any, K: Any, camera_T_shelf: Any) -> None:
    _polygon(canvas, K, camera_T_shelf, [(0, -2, 0), (0.25, -2, 0), (0.25, 2, 0), (0, 2, 0)], 60.0)
    _polygon(canvas, K, camera_T_shelf, [(0, -2, 0), (0, -2, -0.03), (0, 2, -0.03), (0, 2, 0)], 150.0)


def _polygon(canvas: Any, K: Any, camera_T_shelf: Any, corners: Any, grey: float) -> None:
    points = np.array(corners) @ camera_T_shelf[:3, :3].T + camera_T_shelf[:3, 3]
    pixels = points @ K.T
    pixels = np.rint(pixels[:, :2] / pixels[:, 2:] * 16).astype(np.int64).clip(-(2**24), 2**24)
    cv2.fillPoly(canvas, [pixels.astype(np.int32)], grey, cv2.LINE_4, 4)


def row_of_books(
    texts: Sequence[str | None],
    seed: int,
    fonts: tuple[str, ...] = ("DejaVuSans.ttf",),
    gaps: dict[int, float] | None = None,
    left: float = 0.12,
) -> list[Book]:
    """Books standing from `left` to the right in the given order; `gaps` [m] stand before the books of that
    index.
    """
    rng = np.random.default_rng(seed)
    books = []
    for i, text in enumerate(texts):
        left -= (gaps or {}).get(i, 0.0)
        # Upright books lean on each other with a hair of air.
        left -= rng.uniform(0.0, 0.0006)
        thickness, height = rng.uniform(0.015, 0.045), rng.uniform(0.18, 0.24)
        proud, grey = rng.uniform(-0.003, 0.003), int(rng.integers(60, 186))
        font = str(rng.choice(fonts))
        books.append(
            Book(left, thickness, height, proud, grey, text, font, i, False, int(rng.integers(1 << 30)))
        )
        left -= thickness
    return books


class Bookshelf:
    """What tests use of this file, as one fixture (test folders are no packages, so nothing imports it)."""

    camera = CAMERA
    Book = Book
    looking_from = staticmethod(looking_from)
    render = staticmethod(render)
    row_of_books = staticmethod(row_of_books)


@pytest.fixture(scope="session")
def bookshelf() -> Bookshelf:
    return Bookshelf()


class Tabletop:
    """A table from above; its frame: origin in the middle of the picture, x right, y up, z out."""

    camera = CAMERA
    m_per_px = 1.25e-4
    _fine = 2  # rays across a pixel

    def __init__(self) -> None:
        u, v = ((np.arange(n * self._fine) + 0.5) / self._fine - 0.5 for n in (640, 480))
        rays = CAMERA.undistort(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
        self._rays = rays.astype(np.float32).reshape(480 * self._fine, 640 * self._fine, 2)

    def table(self, grey: float = 150.0, seed: int | None = None) -> Any:
        """A bare table (2400, 2400), 300 mm across; with a seed it is of wood."""
        if seed is None:
            return np.full((2400, 2400), grey, dtype=np.uint8)
        rng = np.random.default_rng(seed)
        grain = rng.normal(0.0, 25.0, (600, 12)).astype(np.float32)
        wood = grey + cv2.resize(grain, (2400, 2400), interpolation=cv2.INTER_CUBIC)
        return np.clip(wood, 0, 255).astype(np.uint8)

    def put(self, table: Any, picture: Any, x: float, y: float) -> None:
        """Lays a picture down with its middle at (x, y) in [m]."""
        height, width = picture.shape
        left = round(1200 + x / self.m_per_px - width / 2)
        top = round(1200 - y / self.m_per_px - height / 2)
        table[top : top + height, left : left + width] = picture

    def photograph(
        self, table: Any, camera_T_table: Any, seed: int, noise: float = 3.0, blur: float = 0.7
    ) -> ByteArray:
        """The image (480, 640) through the lens: blur in [px], noise in grey levels, uneven light."""
        to_rays = np.column_stack([camera_T_table[:3, 0], camera_T_table[:3, 1], camera_T_table[:3, 3]])
        m = self.m_per_px
        to_table = np.array([[m, 0.0, -1199.5 * m], [0.0, -m, 1199.5 * m], [0.0, 0.0, 1.0]])
        at = cv2.perspectiveTransform(self._rays, np.linalg.inv(to_rays @ to_table))
        # Average everything between two rays beforehand.
        none: Any = None
        seen = cv2.remap(cv2.blur(table, (3, 3)), at, none, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        small = cv2.resize(seen.astype(np.float32), (640, 480), interpolation=cv2.INTER_AREA)
        image: Any = cv2.GaussianBlur(small, (0, 0), blur)
        rng = np.random.default_rng(seed)
        angle, depth = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.2)
        across = np.linspace(-1.0, 1.0, 640, dtype=np.float32) * np.float32(depth * np.cos(angle))
        down = np.linspace(-1.0, 1.0, 480, dtype=np.float32)[:, None] * np.float32(depth * np.sin(angle))
        image = image * (np.float32(0.92) + across + down)
        image = image + rng.standard_normal(image.shape, dtype=np.float32) * np.float32(noise)
        taken: ByteArray = np.clip(np.rint(image), 0, 255).astype(np.uint8)
        return taken


@pytest.fixture(scope="session")
def tabletop() -> Tabletop:
    return Tabletop()
