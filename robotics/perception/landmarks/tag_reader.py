"""Reading small square tags."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.cameras.planar_pose import planar_poses
from handcart.robotics.perception.landmarks.tag_family import (
    DEFAULT_FAMILY,
    TagFamily,
    corrected_bits,
    dictionary,
)

_ENLARGE = 2
_LEAST_SIDE_PX = 13  # of the tag in the image as taken


class Region(NamedTuple):
    """A part of an image: columns `left` to `right`, rows `top` to `bottom`, ends excluded, in [px]."""

    left: int
    top: int
    right: int
    bottom: int


class Tag(NamedTuple):
    """Tag that was read in an image.

    `id` is its number. `corners` (4, 2) are in [px], clockwise from the tag's own upper left.
    """

    id: int
    corners: FloatArray


def read_tags(
    image: ByteArray, region: Region | None = None, family: TagFamily = DEFAULT_FAMILY
) -> list[Tag]:
    """Return the family's tags in an image or in one region of it, ordered by id.

    A tag with a side of 10 mm is read up to a distance of 0.35 m with a focal length of 800 px. One wrong bit
    is corrected if the family's codes differ enough (`tag_family.corrected_bits`), otherwise none. A smeared
    or partly covered tag may be missed, but is never read as another tag.

    Args:
        image: (h, w), grey.
        region: part of the image that is searched, in [px]; None: the complete image.
        family: family of the tags.
    """
    top, left = 0, 0
    if region is not None:
        top, left = max(0, region.top), max(0, region.left)
        image = image[top : max(top, region.bottom), left : max(left, region.right)]
    if min(image.shape) < _LEAST_SIDE_PX:
        return []
    large = cv2.resize(image, None, fx=_ENLARGE, fy=_ENLARGE, interpolation=cv2.INTER_CUBIC)
    found, ids, _ = _detector(max(large.shape), family).detectMarkers(large)
    if len(found) == 0:
        return []
    tags = [
        # Resizing keeps the outer rim of the pixels, not their centres.
        Tag(int(i), (corners.reshape(4, 2).astype(np.float64) + 0.5) / _ENLARGE - 0.5 + (left, top))
        for i, corners in zip(np.ravel(ids), found, strict=True)
    ]
    return sorted(tags, key=lambda tag: (tag.id, *tag.corners[0]))


class TagPose(NamedTuple):
    """Pose of a tag that explains the tag's corners in a picture, with the remaining reprojection error."""

    camera_T_tag: FloatArray
    """Pose (4, 4) of the tag, whose frame has its origin in the middle, x right, y up, z out of the tag."""
    rms_px: float
    """Root mean square of the corners' residuals, in [px]."""


def tag_pose(tag: Tag, camera: CameraModel, side: float) -> FloatArray:
    """Return the camera_T_tag (4, 4) that fits a tag's corners best: x right, y up, z out of the tag.

    Args:
        tag: tag with its corners in the image.
        camera: model of the camera.
        side: side of the tag's black square, in [m].

    Raises:
        ValueError: the corners are not an image of a square.
    """
    return tag_poses(tag, camera, side)[0].camera_T_tag


def tag_poses(tag: Tag, camera: CameraModel, side: float) -> list[TagPose]:
    """Return both poses of a square that fit its corners, the better one first.

    At a large distance, where the perspective is weak, both poses fit: a tag that is tilted towards the
    camera looks like a tag that is tilted away from it. Both are computed in closed form by the method of
    Collins and Bartoli, "Infinitesimal plane-based pose estimation" (2014).

    Args:
        tag: tag with its corners in the image.
        camera: model of the camera.
        side: side of the tag's black square, in [m].

    Raises:
        ValueError: the corners are not an image of a square.
    """
    half = side / 2
    square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    try:
        poses = planar_poses(square, camera.undistort(tag.corners))
    except ValueError:
        raise ValueError(f"the corners of tag {tag.id} are not an image of a square") from None
    return [TagPose(pose, float(camera.K[0, 0]) * rms) for pose, rms in poses]


def _correction_rate(family: TagFamily) -> float:
    """Return the share of its correctable bits that OpenCV corrects; it rounds their product down."""
    bits = corrected_bits(family)
    return (bits + 0.5) / dictionary(family).maxCorrectionBits if bits else 0.0


@cache
def _detector(longest_px: int, family: TagFamily) -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    # Rates are of the image's longer side: unscaled, a small region is searched for specks (and takes 500
    # times as long).
    parameters.minMarkerPerimeterRate = 4 * _LEAST_SIDE_PX * _ENLARGE / longest_px
    parameters.maxMarkerPerimeterRate = 4.0
    parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = 31
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.cornerRefinementWinSize = 6
    parameters.errorCorrectionRate = _correction_rate(family)
    parameters.maxErroneousBitsInBorderRate = 0.1
    parameters.perspectiveRemovePixelPerCell = 8
    parameters.perspectiveRemoveIgnoredMarginPerCell = 0.25
    return cv2.aruco.ArucoDetector(dictionary(family), parameters)
