"""An image as a picture of a plane."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel


class PlaneView(NamedTuple):
    """Grey image (h, w) of a plane, for reading the grey at points of the plane.

    The plane is z = 0 of a frame whose pose `camera_T_plane` (4, 4) is known. Points are given in the frame
    of a pose in the plane, in [m].
    """

    image: ByteArray
    camera: CameraModel
    camera_T_plane: Transform

    def eye(self, pose: Pose2) -> FloatArray:
        """Return the position (3,) of the camera, in [m], in the frame of a pose in the plane; z is normal to
        the plane.

        Args:
            pose: pose in the plane, in [m] and [rad], in the frame of `camera_T_plane`.
        """
        camera_T_pose = self.camera_T_plane @ pose.lift()
        return np.asarray(-camera_T_pose[:3, :3].T @ camera_T_pose[:3, 3])

    def pixels(self, pose: Pose2, points: FloatArray) -> FloatArray:
        """Return the pixels (..., 2), column and row in [px], of points in the plane.

        Args:
            pose: pose in the plane, in whose frame the points are.
            points: (..., 2) in [m].
        """
        camera_T_pose = self.camera_T_plane @ pose.lift()
        space = points.reshape(-1, 2) @ camera_T_pose[:3, :2].T + camera_T_pose[:3, 3]
        return self.camera.project(space).reshape(points.shape)

    def profiles(self, pose: Pose2, first: FloatArray, last: FloatArray, count: int) -> FloatArray | None:
        """Return grey levels (..., count), from 0 to 255, along short lines in the plane; None if a line
        leaves the image.

        The lens model is applied only to the ends of a line, because a line of a few millimetres stays
        straight.

        Args:
            pose: pose in the plane, in whose frame the lines are.
            first: (..., 2) starts of the lines, in [m].
            last: (..., 2) ends of the lines, in [m].
            count: number of grey levels along each line.
        """
        ends = self.pixels(pose, np.stack([first, last]))
        height, width = self.image.shape
        low, high = ends.reshape(-1, 2).min(axis=0), ends.reshape(-1, 2).max(axis=0)
        if not (low.min() >= 1.0 and high[0] <= width - 2 and high[1] <= height - 2):
            return None
        share = np.linspace(0.0, 1.0, count, dtype=np.float32)[:, None]
        start, end = (row.reshape(-1, 1, 2).astype(np.float32) for row in ends)
        along = start + (end - start) * share
        greys = cv2.remap(self.image, along[..., 0], along[..., 1], cv2.INTER_LINEAR)
        result: FloatArray = greys.astype(np.float64).reshape(*first.shape[:-1], count)
        return result
