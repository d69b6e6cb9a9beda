"""Measure how well call numbers are read: python benchmarks/books/perception.py [labels a face]

Labels in faces that the reader was not made from, at 0.375 mm a pixel: blur 0.7 px, noise sigma 3, lens k1
= -0.28, a light gradient, small tilts; three views of each label. "Wrong" counts call numbers that differ
from the label's.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import matplotlib.font_manager
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.backends.simulation.books.textures import draw_spine, label_fonts
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.perception.books.call_number import CallNumber, parse, snap
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.books.shelf_views import fuse_labels
from handcart.robotics.perception.cameras.camera_model import CameraModel, plane_to_rays

CAMERA_MODEL = CameraModel(
    np.array([[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]),
    np.array([-0.28, 0.09, 0.0, 0.0, 0.0]),
    640,
    480,
)
ROW, THICKNESS, HEIGHT, DISTANCE, PX_PER_MM = 6, 0.028, 0.2, 0.3, 6
CATALOGUE_SIZE = 600
# The same designs as faces that matplotlib ships, or no text faces.
SYSTEM_FACES = ("liberation", "freefont", "freesans", "freeserif", "freemono", "condensed", "extralight")


class Shelf(NamedTuple):
    """A flat picture of some spines, and where each label's middle is (y in [m])."""

    picture: ByteArray
    left: float
    numbers: list[CallNumber]


def faces() -> list[str]:
    found = matplotlib.font_manager.findSystemFonts(fontext="ttf")
    system = sorted(path for path in found if any(word in path.lower() for word in SYSTEM_FACES))
    return [*label_fonts(), *system]


def call_numbers(rng: np.random.Generator) -> Iterator[CallNumber]:
    """Different call numbers without end: 0 to 3 decimals, three letters."""
    while True:
        decimals = str(rng.integers(0, 1000))[: int(rng.integers(0, 4))]
        letters = "".join(chr(65 + int(i)) for i in rng.integers(0, 26, 3))
        number = parse(f"{rng.integers(0, 1000):03d}{'.' if decimals else ''}{decimals}{letters}")
        if number is not None:
            yield number


def shelf(numbers: list[CallNumber], face: str, rng: np.random.Generator) -> Shelf:
    spines = [
        draw_spine(
            THICKNESS * 1e3,
            HEIGHT * 1e3,
            int(rng.integers(60, 186)),
            None,
            str(number),
            face,
            PX_PER_MM,
            seed=i,
        )
        for i, number in enumerate(numbers)
    ]
    return Shelf(np.hstack(spines), ROW * THICKNESS / 2, numbers)


def photograph(row: Shelf, camera_T_shelf: FloatArray, rng: np.random.Generator) -> ByteArray:
    """Return the row seen through the lens, with a camera's blur, noise and uneven light."""
    columns, lines = np.meshgrid(np.arange(CAMERA_MODEL.width), np.arange(CAMERA_MODEL.height))
    rays = CAMERA_MODEL.undistort(np.column_stack([columns.ravel(), lines.ravel()]).astype(np.float64))
    points = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(plane_to_rays(camera_T_shelf)).T
    u = (row.left - points[:, 0] / points[:, 2]) * 1e3 * PX_PER_MM - 0.5
    v = (HEIGHT - points[:, 1] / points[:, 2]) * 1e3 * PX_PER_MM - 0.5
    # One pixel covers more than two of the picture: averaged before it is sampled.
    soft = cv2.GaussianBlur(row.picture.astype(np.float32), (0, 0), 0.7)
    grid = (CAMERA_MODEL.height, CAMERA_MODEL.width)
    image = cv2.remap(
        soft, u.astype(np.float32).reshape(grid), v.astype(np.float32).reshape(grid), cv2.INTER_LINEAR
    )
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    angle, depth = rng.uniform(0, 2 * np.pi), rng.uniform(0.05, 0.2)
    slope = np.cos(angle) * (columns / 320 - 1) + np.sin(angle) * (lines / 240 - 1)
    noisy = image * (0.92 + depth * slope) + rng.normal(0.0, 3.0, grid)
    pixels: ByteArray = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return pixels


def pose(lateral: float, rng: np.random.Generator) -> FloatArray:
    """camera_T_shelf of a camera in front of `lateral`, up to two degrees askew."""
    look = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    shelf_T_camera = transform((-DISTANCE, lateral, 0.09), rng.uniform(-0.035, 0.035, 3).tolist())
    shelf_T_camera[:3, :3] = shelf_T_camera[:3, :3] @ look
    return inverse(shelf_T_camera)


def verdict(read: CallNumber | None, truth: CallNumber) -> str:
    return "unread" if read is None else "right" if read == truth else "wrong"


def main() -> None:
    cv2.setNumThreads(1)
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("labels", nargs="?", type=int, default=60, help="of each face")
    per_face = words.parse_args().labels
    rng = np.random.default_rng(7)
    source = call_numbers(rng)
    catalogue = [next(source) for _ in range(CATALOGUE_SIZE)]
    reader = OcrLabelReader()
    counts = {name: Counter[str]() for name in ("one view", "  + catalogue", "three fused", "  + catalogue ")}
    spent, views = 0.0, 0
    for face in faces():
        before = counts["three fused"].copy()
        for _ in range(-(-per_face // ROW)):
            numbers = [catalogue[int(i)] for i in rng.choice(CATALOGUE_SIZE, ROW, replace=False)]
            row = shelf(numbers, face, rng)
            seen: list[list[Label]] = [[] for _ in numbers]
            for lateral in (-0.02, 0.0, 0.02):
                camera_T_shelf = pose(lateral, rng)
                image = photograph(row, camera_T_shelf, rng)
                start = time.process_time()
                for label in reader.read(image, CAMERA_MODEL, camera_T_shelf):
                    seen[min(ROW - 1, max(0, int((row.left - label.lateral) / THICKNESS)))].append(label)
                spent, views = spent + time.process_time() - start, views + 1
            for truth, labels in zip(numbers, seen, strict=True):
                count(counts, truth, labels, catalogue)
        now = counts["three fused"] - before
        print(f"{Path(face).name:36} fused: {now['right']}/{sum(now.values())} right, {now['wrong']} wrong")
    print(f"\n{'':16}{'labels':>8}{'right':>10}{'wrong':>10}{'unread':>10}")
    for name, tally in counts.items():
        total = sum(tally.values())
        shares = "".join(f"{tally[kind] / total:>10.2%}" for kind in ("right", "wrong", "unread"))
        print(f"{name:16}{total:>8}{shares}")
    print(f"\n{1e3 * spent / views:.0f} ms of CPU a view of {ROW} labels, {views} views")


def count(
    counts: dict[str, Counter[str]], truth: CallNumber, labels: list[Label], catalogue: list[CallNumber]
) -> None:
    snapped = [label._replace(call_number=snap(label.text, catalogue)) for label in labels]
    for name in ("one view", "  + catalogue"):
        counts[name]["unread"] += max(0, 3 - len(labels))
    for plain, known in zip(labels, snapped, strict=True):
        counts["one view"][verdict(plain.call_number, truth)] += 1
        counts["  + catalogue"][verdict(known.call_number, truth)] += 1
    counts["three fused"][verdict(fuse_labels(labels)[0], truth)] += 1
    counts["  + catalogue "][verdict(fuse_labels(snapped)[0], truth)] += 1


if __name__ == "__main__":
    main()
