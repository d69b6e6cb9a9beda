"""Families of square tags: ArUco's dictionaries and AprilTag's (Olson, 2011)."""

from __future__ import annotations

from functools import cache
from typing import Literal, get_args

import cv2

TagFamily = Literal[
    "4x4_50",
    "4x4_100",
    "4x4_250",
    "4x4_1000",
    "5x5_50",
    "5x5_100",
    "5x5_250",
    "5x5_1000",
    "6x6_50",
    "6x6_100",
    "6x6_250",
    "6x6_1000",
    "7x7_50",
    "7x7_100",
    "7x7_250",
    "7x7_1000",
    "aruco_original",
    "aruco_mip_36h12",
    "apriltag_16h5",
    "apriltag_25h9",
    "apriltag_36h10",
    "apriltag_36h11",
]
"""Names of families, by bits along and down and number of tags, or by all bits and their Hamming distance."""

DEFAULT_FAMILY: TagFamily = "5x5_250"

CORRECTING_FAMILIES: tuple[TagFamily, ...] = (
    "apriltag_25h9",
    "apriltag_36h10",
    "apriltag_36h11",
    "aruco_mip_36h12",
)
"""Families of which one bit is corrected: any two codes, in any of four turns, differ in 9 bits or more."""


@cache
def dictionary(family: TagFamily) -> cv2.aruco.Dictionary:
    """Return OpenCV's dictionary with the codes of a tag family.

    Raises:
        ValueError: the family is unknown.
    """
    if family not in get_args(TagFamily):
        raise ValueError(f"unknown family of tags {family!r}; allowed: {', '.join(get_args(TagFamily))}")
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{family.upper()}"))


def corrected_bits(family: TagFamily) -> int:
    """Return how many wrongly read bits can be corrected in each tag of a family.

    It is 1 for the families in `CORRECTING_FAMILIES`, whose codes differ in enough bits, otherwise 0.
    """
    return int(family in CORRECTING_FAMILIES)


def tags_of(family: TagFamily) -> int:
    """Return the number of tags of a family; they are numbered from 0."""
    return int(dictionary(family).bytesList.shape[0])


def modules_of(family: TagFamily) -> int:
    """Return the number of fields along the side of a tag's black square, the black frame included."""
    return int(dictionary(family).markerSize) + 2
