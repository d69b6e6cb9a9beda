"""Measure the speed and accuracy of the landmark detector: python benchmarks/blocks/landmark.py [images]

One thread, 640x480, f = 800 px, 300 mm above the mark, k1 = -0.28, k2 = 0.09, blur 0.7 px, noise sigma 3.
Times are minima over many runs on one image; errors are root mean squares and maxima over images with the
mark in any direction. The comparison: an ArUco tag of equal size with OpenCV's corner refinements, its
corners undistorted and projected onto the plane in the same way, and a simple detector (threshold,
contour, cornerSubPix).
"""

from __future__ import annotations

import argparse
import math
import sys
import timeit
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.landmark import INK, PAPER, draw_landmark, seen_landmark
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_pose import facing, planar_pose

CAMERA_MODEL = CameraModel(
    np.array([[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]),
    np.array([-0.28, 0.09, 0.0, 0.0, 0.0]),
    640,
    480,
)
HEIGHT, M_PER_PX, TABLE_PX, FINE = 0.3, 1.25e-4, 2400, 3
OFFSETS_M = (0.0004, 0.03, 0.06)
Finder = Callable[[ByteArray], FloatArray | None]  # corners as rays (4, 2), from the upper left


def rays() -> FloatArray:
    """Return some rays in each pixel (n, 3)."""
    u, v = (
        (np.arange(count * FINE) + 0.5) / FINE - 0.5 for count in (CAMERA_MODEL.width, CAMERA_MODEL.height)
    )
    flat = CAMERA_MODEL.undistort(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    return np.column_stack([flat, np.ones(len(flat))])


def photograph(table: ByteArray, pose: Pose2, looking: FloatArray, rng: np.random.Generator) -> ByteArray:
    """Return the image of a table with the mark in its middle at `pose` below the camera."""
    camera_T_table = facing(HEIGHT) @ pose.lift()
    plane = np.column_stack([camera_T_table[:3, 0], camera_T_table[:3, 1], camera_T_table[:3, 3]])
    points = looking @ np.linalg.inv(plane).T
    grid, middle = (CAMERA_MODEL.height * FINE, CAMERA_MODEL.width * FINE), (TABLE_PX - 1) / 2
    columns = (middle + points[:, 0] / points[:, 2] / M_PER_PX).astype(np.float32).reshape(grid)
    rows = (middle - points[:, 1] / points[:, 2] / M_PER_PX).astype(np.float32).reshape(grid)
    fine = cv2.remap(table, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    small = cv2.resize(
        fine.astype(np.float32), (CAMERA_MODEL.width, CAMERA_MODEL.height), interpolation=cv2.INTER_AREA
    )
    image = cv2.GaussianBlur(small, (0, 0), 0.7) + rng.normal(0.0, 3.0, small.shape)
    pixels: ByteArray = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return pixels


def table_with(sheet: ByteArray) -> ByteArray:
    table = np.full((TABLE_PX, TABLE_PX), 150, dtype=np.uint8)
    start = (TABLE_PX - sheet.shape[0]) // 2
    table[start : start + sheet.shape[0], start : start + sheet.shape[0]] = sheet
    return table


def tag_sheet() -> ByteArray:
    marker = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 7, 480)
    return np.pad(np.where(marker > 0, PAPER, INK).astype(np.uint8), 80, constant_values=PAPER)


def ours(image: ByteArray) -> FloatArray | None:
    found = find_landmarks(image, CAMERA_MODEL)
    return found[0].rays if found else None


def aruco(refinement: int) -> Finder:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = refinement
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    detector = cv2.aruco.ArucoDetector(dictionary, parameters)

    def find(image: ByteArray) -> FloatArray | None:
        corners, _, _ = detector.detectMarkers(image)
        return CAMERA_MODEL.undistort(corners[0].reshape(4, 2).astype(np.float64)) if corners else None

    return find


def plain(image: ByteArray) -> FloatArray | None:
    """Find the corners by Otsu's threshold, the largest quadrangle and cornerSubPix, without the
    direction.
    """
    _, dark = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    outlines, _ = cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    squares = [cv2.approxPolyDP(outline, 0.03 * cv2.arcLength(outline, True), True) for outline in outlines]
    squares = [square for square in squares if len(square) == 4 and 5e3 < cv2.contourArea(square) < 1e5]
    if not squares:
        return None
    corners = min(squares, key=cv2.contourArea).astype(np.float32)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 0.01)
    cv2.cornerSubPix(image, corners, (5, 5), (-1, -1), criteria)
    return CAMERA_MODEL.undistort(corners.reshape(4, 2).astype(np.float64)[::-1])


def errors(find: Finder, images: list[ByteArray], poses: list[Pose2]) -> tuple[list[float], list[float], int]:
    """Return errors of centres [mm], of angles modulo a quarter turn [mrad], and the number not found."""
    centres, angles, missed = [], [], 0
    for image, pose in zip(images, poses, strict=True):
        corners = find(image)
        if corners is None:
            missed += 1
            continue
        found = planar_pose(seen_landmark(corners, CAMERA_MODEL, 1.0), facing(HEIGHT))
        centres.append(1e3 * found.distance(pose))
        turn = (found.theta - pose.theta + math.pi / 4) % (math.pi / 2) - math.pi / 4
        angles.append(1e3 * abs(turn))
    return centres, angles, missed


def main() -> None:
    cv2.setNumThreads(1)
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("images", nargs="?", type=int, default=30)
    count = words.parse_args().images
    looking = rays()
    sheets = {"landmark": table_with(draw_landmark()), "tag": table_with(tag_sheet())}
    finders: list[tuple[str, str, Finder]] = [
        ("landmark, find_landmarks", "landmark", ours),
        ("landmark, threshold + cornerSubPix", "landmark", plain),
        ("ArUco, corners as found", "tag", aruco(cv2.aruco.CORNER_REFINE_NONE)),
        ("ArUco, CORNER_REFINE_SUBPIX", "tag", aruco(cv2.aruco.CORNER_REFINE_SUBPIX)),
        ("ArUco, CORNER_REFINE_CONTOUR", "tag", aruco(cv2.aruco.CORNER_REFINE_CONTOUR)),
    ]
    rng = np.random.default_rng(1)
    first = {name: photograph(table, Pose2(0.0, 0.0, 0.3), looking, rng) for name, table in sheets.items()}
    print(f"{'':38}{'least ms':>10}{'ratio':>8}")
    base = 0.0
    for name, sheet, find in finders:
        image = first[sheet]
        least = min(timeit.repeat(lambda f=find, i=image: f(i), number=1, repeat=200)) * 1e3  # type: ignore[misc]
        base = base or least
        print(f"{name:38}{least:10.2f}{least / base:8.1f}")
    for offset in OFFSETS_M:
        bearings = rng.uniform(-0.2, 0.2, count)
        poses = [
            Pose2(offset * math.cos(b), offset * math.sin(b), float(turn))
            for b, turn in zip(bearings, rng.uniform(-math.pi, math.pi, count), strict=True)
        ]
        title = f"{1e3 * offset:.0f} mm off centre"
        print(f"\n{title:38}{'centre rms':>12}{'max mm':>9}{'angle rms':>11}{'max mrad':>10}{'lost':>6}")
        taken = {name: [photograph(table, p, looking, rng) for p in poses] for name, table in sheets.items()}
        for name, sheet, find in finders:
            centres, angles, missed = errors(find, taken[sheet], poses)
            if not centres:
                print(f"{name:38}{'never found':>12}")
                continue
            rms = [math.sqrt(float(np.mean(np.square(item)))) for item in (centres, angles)]
            print(f"{name:38}{rms[0]:12.4f}{max(centres):9.4f}{rms[1]:11.3f}{max(angles):10.3f}{missed:6}")


if __name__ == "__main__":
    main()
