"""Pictures of a box's sides with the tags printed on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from handcart.backends.description.things.printed_tag import FACE_AXES, UNIT_TAG_CORNERS, Face, PrintedTag
from handcart.robotics.geometry.transform import apply, inverse
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.landmarks.tag_family import dictionary, modules_of

PX_PER_MM = 5
INK, PAPER = 25, 235
QUIET_SHARE = 0.2  # of a tag's side: the white margin on each side of it
MODULE_PX = 16


def printed_faces(
    tags: Sequence[PrintedTag], size_mm: tuple[float, float, float], grey: int
) -> Mapping[Face, ByteArray]:
    """Return the grey pictures (h, w) of the sides with tags, as seen from outside with z up.

    Args:
        tags: the tags.
        size_mm: size of the box along its x, y and z, in [mm].
        grey: grey of the side around the tags, 0 to 255.
    """
    faces: dict[Face, ByteArray] = {}
    for tag in tags:
        along, up = FACE_AXES[tag.face[1]]
        if tag.face not in faces:
            faces[tag.face] = np.full(
                (round(size_mm[up] * PX_PER_MM), round(size_mm[along] * PX_PER_MM)), grey, np.uint8
            )
        _print(faces[tag.face], tag)
    return faces


def _print(picture: ByteArray, tag: PrintedTag) -> None:
    """Print a tag with its white margin, turned as it is, onto the picture of its side."""
    modules = modules_of(tag.family)
    black = MODULE_PX * modules
    quiet = round(QUIET_SHARE * black)
    marker = cv2.aruco.generateImageMarker(dictionary(tag.family), tag.id, black).astype(np.float32)
    ink = (INK + marker * ((PAPER - INK) / 255.0)).astype(np.float32)
    sheet = np.pad(ink, quiet, constant_values=PAPER)
    height, width = picture.shape
    flat = inverse(PrintedTag(id=0, side_mm=1.0, face=tag.face).on_box((0.0, 0.0, 0.0)))
    spots = apply(flat @ tag.on_box((0.0, 0.0, 0.0)), UNIT_TAG_CORNERS * tag.side_mm / 1e3) * 1e3 * PX_PER_MM
    goals = np.column_stack([width / 2 + spots[:, 0], height / 2 - spots[:, 1]]) - 0.5
    sources = np.array([[0, 0], [black, 0], [black, black], [0, black]]) + quiet - 0.5
    homography = np.asarray(
        cv2.getPerspectiveTransform(sources.astype(np.float32), goals.astype(np.float32)), np.float64
    )
    fine = _warped(sheet, homography, (width, height))
    cover = _warped(np.ones(sheet.shape, np.float32), homography, (width, height))
    picture[:] = np.rint(picture * (1.0 - cover) + fine * cover).astype(np.uint8)


def _warped(
    sheet: SingleArray,
    homography: FloatArray,
    size: tuple[int, int],
) -> SingleArray:
    return np.asarray(cv2.warpPerspective(sheet, homography, size, flags=cv2.INTER_LINEAR), np.float32)
