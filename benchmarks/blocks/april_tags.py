"""AprilTags read, with and without a damaged bit: `python -m benchmarks.blocks.april_tags`

Draws pictures of twelve tags (36h11) each: turned a little, of 30 to 160 px, dim to bright, blurred,
noisy. Of a damaged tag one bit is turned over. Then pictures without a tag: smoothed noise, stripes,
rectangles, and frames of a tag with random bits inside. Each picture is read by handcart and by OpenCV's
detector with its default settings. Prints how many tags each reads, and how many ids that no tag in the
picture has. Status 1 where handcart reads a false id, or fewer damaged tags than --least percent.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np
from rich.console import Console
from rich.progress import track

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.landmarks.tag_family import TagFamily, dictionary, modules_of, tags_of
from handcart.robotics.perception.landmarks.tag_reader import read_tags

TAG_FAMILY: TagFamily = "apriltag_36h11"
HEIGHT, WIDTH = 960, 1280
TAG_COUNT = 12
CELL_PX = 10  # [px] of a drawn tag
TAG_SIDES_PX = (30.0, 160.0)  # [px] of a tag with its white rim
FRAME_COUNT = 6  # with random bits, in a picture without tags
Reader = Callable[[ByteArray], set[int]]


class Picture(NamedTuple):
    """A picture and the tags in it."""

    image: ByteArray
    ids: set[int]


class Count(NamedTuple):
    """Tags read, tags there, ids read that are not there."""

    read: int = 0
    there: int = 0
    false: int = 0

    def plus(self, picture: Picture, found: set[int]) -> Count:
        """Add a picture and what was read in it."""
        read, false = len(found & picture.ids), len(found - picture.ids)
        return Count(self.read + read, self.there + len(picture.ids), self.false + false)


def tagged(seed: int, damaged_bits: int) -> Picture:
    """Draw twelve tags, each with so many bits turned over."""
    rng = np.random.default_rng(seed)
    light = np.linspace(-40.0, 60.0, WIDTH)
    ground = np.asarray(
        cv2.GaussianBlur(rng.normal(120.0, 25.0, (HEIGHT, WIDTH)), (0, 0), 3.0) + light, np.float64
    )
    ids = rng.choice(tags_of(TAG_FAMILY), TAG_COUNT, replace=False)
    for place, number in enumerate(ids):
        _paste(ground, _marker(int(number), damaged_bits, rng), place, rng)
    return Picture(_taken(ground, rng), set(ids.tolist()))


def untagged(seed: int) -> Picture:
    """Draw a texture, and frames of tags with random bits inside."""
    rng = np.random.default_rng(seed)
    draw = (_smoothed_noise, _stripes, _rectangles)[seed % 3]
    ground = draw(rng)
    for place in rng.choice(TAG_COUNT, FRAME_COUNT, replace=False).tolist():
        inner = modules_of(TAG_FAMILY) - 2
        bits = rng.integers(0, 2, (inner, inner)) * 255.0
        cells = np.kron(np.pad(bits, 1), np.ones((CELL_PX, CELL_PX)))
        _paste(ground, np.pad(cells, CELL_PX, constant_values=255.0), place, rng)
    return Picture(_taken(ground, rng), set())


def ours(image: ByteArray) -> set[int]:
    """Read the tags of a picture as handcart does."""
    return {tag.id for tag in read_tags(image, family=TAG_FAMILY)}


def stock() -> Reader:
    """Return OpenCV's detector as it comes."""
    detector = cv2.aruco.ArucoDetector(dictionary(TAG_FAMILY))

    def read(image: ByteArray) -> set[int]:
        _, ids, _ = detector.detectMarkers(image)
        return set() if ids is None else {int(number) for number in np.ravel(ids)}

    return read


def _marker(number: int, damaged_bits: int, rng: np.random.Generator) -> FloatArray:
    inner = modules_of(TAG_FAMILY) - 2
    cells = dictionary(TAG_FAMILY).generateImageMarker(number, CELL_PX * (inner + 2)).astype(np.float64)
    for where in rng.choice(inner * inner, damaged_bits, replace=False).tolist():
        row, column = CELL_PX * (1 + where // inner), CELL_PX * (1 + where % inner)
        cells[row : row + CELL_PX, column : column + CELL_PX] = (
            255.0 - cells[row : row + CELL_PX, column : column + CELL_PX]
        )
    return np.pad(cells, CELL_PX, constant_values=255.0)


def _paste(ground: FloatArray, cells: FloatArray, place: int, rng: np.random.Generator) -> None:
    """Put a tag into one of twelve places of a picture, in perspective and in its own light."""
    half, drawn = rng.uniform(*TAG_SIDES_PX) / 2.0, float(len(cells))
    middle = np.array([160.0 + 320.0 * (place % 4), 160.0 + 320.0 * (place // 4)])
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) + middle
    seen = (corners + rng.normal(0.0, 0.14 * half, (4, 2))).astype(np.float32)
    own = np.array([[0, 0], [drawn, 0], [drawn, drawn], [0, drawn]], np.float32)
    turn = cv2.getPerspectiveTransform(own, seen)
    tag = cv2.warpPerspective(cells, turn, (WIDTH, HEIGHT), flags=cv2.INTER_AREA)
    covered = cv2.warpPerspective(np.ones_like(cells), turn, (WIDTH, HEIGHT)) > 0.5
    gain, offset = rng.uniform(0.4, 1.0), rng.uniform(0.0, 60.0)
    ground[covered] = (tag * gain + offset)[covered]


def _taken(ground: FloatArray, rng: np.random.Generator) -> ByteArray:
    """Return the picture that a camera takes: blurred and noisy."""
    blurred = cv2.GaussianBlur(ground, (0, 0), rng.uniform(0.6, 1.6))
    noisy = blurred + rng.normal(0.0, 6.0, blurred.shape)
    return np.asarray(np.clip(noisy, 0.0, 255.0), np.uint8)


def _smoothed_noise(rng: np.random.Generator) -> FloatArray:
    noise = cv2.GaussianBlur(rng.normal(0.0, 1.0, (HEIGHT, WIDTH)), (0, 0), rng.uniform(1.0, 12.0))
    return np.asarray(128.0 + rng.uniform(40.0, 120.0) * noise / noise.std(), np.float64)


def _stripes(rng: np.random.Generator) -> FloatArray:
    rows, columns = (np.sin(np.arange(size) / rng.uniform(2.0, 30.0)) for size in (HEIGHT, WIDTH))
    return np.asarray(128.0 + 120.0 * np.sign(rows[:, None] * columns), np.float64)


def _rectangles(rng: np.random.Generator) -> FloatArray:
    ground = np.full((HEIGHT, WIDTH), 200.0)
    for _ in range(400):
        row, column = int(rng.integers(HEIGHT)), int(rng.integers(WIDTH))
        height, width = rng.integers(4, 90, 2).tolist()
        ground[row : row + height, column : column + width] = rng.uniform(0.0, 255.0)
    return ground


def main() -> None:
    """Print the table."""
    words = argparse.ArgumentParser(
        prog="python -m benchmarks.blocks.april_tags",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    words.add_argument("--pictures", type=int, default=12, help="with twelve tags each, of each kind")
    words.add_argument("--random", type=int, default=1000, help="pictures without a tag")
    words.add_argument("--first", type=int, default=0, help="the first seed")
    words.add_argument("--least", type=float, default=90.0, help="percent of damaged tags to be read")
    chosen = words.parse_args()
    kinds: dict[str, tuple[Callable[[int], Picture], int]] = {
        "whole": (lambda seed: tagged(seed, 0), chosen.pictures),
        "one damaged bit": (lambda seed: tagged(seed, 1), chosen.pictures),
        "two damaged bits": (lambda seed: tagged(seed, 2), chosen.pictures),
        "no tag": (untagged, chosen.random),
    }
    readers: dict[str, Reader] = {"handcart": ours, "OpenCV": stock()}
    print(f"{'':18}" + "".join(f"{name:>20}{'false ids':>11}" for name in readers), flush=True)
    failed = False
    for kind, (draw, pictures) in kinds.items():
        counts = dict.fromkeys(readers, Count())
        seeds = range(chosen.first, chosen.first + pictures)
        for seed in track(seeds, kind, console=Console(stderr=True)):
            picture = draw(seed)
            counts = {name: counts[name].plus(picture, read(picture.image)) for name, read in readers.items()}
        cells = (f"{f'{count.read} of {count.there}':>20}{count.false:>11}" for count in counts.values())
        print(f"{kind:18}" + "".join(cells), flush=True)
        own = counts["handcart"]
        few = kind == "one damaged bit" and own.read < chosen.least / 100.0 * own.there
        failed |= own.false > 0 or few
    sys.exit(failed)


if __name__ == "__main__":
    main()
