"""A camera with lens distortion: points to pixels, pixels to rays, pixels to points of a plane."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.lens_fold import LensKind, fold_radius

FISHEYE_FAILED = 1e5  # of a ray from OpenCV that its fisheye model has not found


class CameraModel(NamedTuple):
    """Model of a camera with its lens, which relates points in space to pixels.

    The camera frame has z forward, x to the right and y down. Integer coordinates are those of a pixel's
    centre.
    """

    K: FloatArray
    """Intrinsic matrix (3, 3), in [px]."""
    distortion: FloatArray
    """OpenCV's coefficients: (4,), (5,) or (8,) k1, k2, p1, p2, k3, k4, k5, k6 of `brown`, (4,) of
    `fisheye`.
    """
    width: int
    """Width of the picture, in [px]."""
    height: int
    """Height of the picture, in [px]."""
    lens: LensKind = "brown"

    def project(self, points: FloatArray) -> FloatArray:
        """Return the pixels (n, 2) of points, column and row in [px].

        Points behind the camera give NaN. So do points farther off the axis than the lens model is valid
        (`fold_radius`), because it would map them back into the picture.

        Args:
            points: (n, 3) in the camera frame, in [m].
        """
        if len(points) == 0:
            return np.empty((0, 2))
        zero, source = np.zeros(3), points.reshape(-1, 1, 3)
        if self.lens == "fisheye":
            pixels, _ = cv2.fisheye.projectPoints(source, zero, zero, self.K, self.distortion)
        else:
            pixels, _ = cv2.projectPoints(source, zero, zero, self.K, self.distortion)
        result: FloatArray = pixels.reshape(-1, 2).astype(np.float64)
        fold = fold_radius(self.distortion, self.lens)
        far = np.hypot(points[:, 0], points[:, 1]) >= fold * points[:, 2] if fold < np.inf else False
        result[(points[:, 2] <= 0.0) | far] = np.nan
        return result

    def undistort(self, pixels: FloatArray) -> FloatArray:
        """Return the rays (n, 2) through pixels, x/z and y/z in the camera frame, with lens distortion
        removed.

        A ray is NaN if the iteration finds none.

        Args:
            pixels: (n, 2) column and row, in [px].
        """
        if len(pixels) == 0:
            return np.empty((0, 2))
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-10)
        source = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
        if self.lens == "fisheye":
            seen = cv2.fisheye.undistortPoints(source, self.K, self.distortion).reshape(-1, 2)
            return np.where(np.abs(seen) < FISHEYE_FAILED, seen, np.nan).astype(np.float64)
        rays = cv2.undistortPointsIter(source, self.K, self.distortion, np.eye(3), np.eye(3), criteria)
        result: FloatArray = rays.reshape(-1, 2).astype(np.float64)
        return result

    def pixel_on_plane(self, pixels: FloatArray, camera_T_plane: FloatArray, x: float = 0.0) -> FloatArray:
        """Return the points at which rays through pixels meet a plane parallel to x = 0 of a frame.

        The plane is one of constant x, not z, because in shelf frames x points into the shelf. Rays that meet
        the plane behind the camera or not at all give NaN.

        Args:
            pixels: (n, 2) column and row, in [px].
            camera_T_plane: (4, 4) pose of the frame, translation in [m].
            x: distance of the plane along the frame's x, in [m].

        Returns:
            y and z (n, 2) in the frame, in [m].
        """
        rays = np.column_stack([self.undistort(pixels), np.ones(len(pixels))])
        to_plane = np.linalg.inv(plane_to_rays(camera_T_plane, x))
        meets = rays @ to_plane.T
        with np.errstate(divide="ignore", invalid="ignore"):
            points: FloatArray = meets[:, :2] / meets[:, 2:]
        points[~(meets[:, 2] > 1e-12)] = np.nan
        return points

    def plane_in_image(self, points: FloatArray, camera_T_plane: FloatArray, x: float = 0.0) -> FloatArray:
        """Project points on a plane into the image; return their pixels (n, 2), column and row in [px].

        Args:
            points: (n, 2) y and z in the plane's frame, in [m].
            camera_T_plane: (4, 4) pose of the frame, translation in [m].
            x: distance of the plane along the frame's x, in [m].
        """
        space = np.column_stack([np.full(len(points), x), points])
        return self.project(space @ camera_T_plane[:3, :3].T + camera_T_plane[:3, 3])

    def rectify(self, image: ByteArray, picture_to_rays: FloatArray, size: tuple[int, int]) -> ByteArray:
        """Return a grey picture (h, w) of a flat sheet, without lens distortion and perspective.

        Pixels outside of the image are 0.

        Args:
            image: (h, w), grey.
            picture_to_rays: (3, 3) homography from (column, row, 1) of the picture to a ray in the camera
                frame.
            size: width and height of the picture, in [px].
        """
        # OpenCV inverts its "new camera matrix" to get exactly this map; any homography does.
        inverse = np.linalg.inv(picture_to_rays)
        undo = cv2.fisheye.initUndistortRectifyMap if self.lens == "fisheye" else cv2.initUndistortRectifyMap
        columns, rows = undo(self.K, self.distortion, np.eye(3), inverse, size, cv2.CV_32FC1)
        return cv2.remap(image, columns, rows, cv2.INTER_CUBIC).astype(np.uint8, copy=False)


def plane_to_rays(camera_T_plane: FloatArray, x: float = 0.0) -> FloatArray:
    """Return the homography (3, 3) that maps a point (y, z, 1) of a plane, in [m], to its ray in the camera
    frame.

    Args:
        camera_T_plane: (4, 4) pose of the plane's frame, translation in [m].
        x: distance of the plane along the frame's x, in [m].
    """
    rotation, origin = camera_T_plane[:3, :3], camera_T_plane[:3, 3]
    return np.column_stack([rotation[:, 1], rotation[:, 2], origin + rotation[:, 0] * x])


def picture_of_plane(
    camera_T_plane: FloatArray, upper_left: tuple[float, float], m_per_px: float, x: float = 0.0
) -> FloatArray:
    """Return the homography (3, 3) from (column, row, 1) of a picture of a plane to rays of the camera frame.

    The picture shows the plane as seen from the side of -x of its frame, with y to the left and z up.

    Args:
        camera_T_plane: (4, 4) pose of the plane's frame, translation in [m].
        upper_left: y and z of the picture's first pixel, in [m].
        m_per_px: size of a pixel, in [m].
        x: distance of the plane along the frame's x, in [m].
    """
    to_plane = np.array([[-m_per_px, 0.0, upper_left[0]], [0.0, -m_per_px, upper_left[1]], [0.0, 0.0, 1.0]])
    picture_to_rays: FloatArray = plane_to_rays(camera_T_plane, x) @ to_plane
    return picture_to_rays
