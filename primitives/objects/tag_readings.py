"""Objects in pictures, by their tags."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.description.printed_tag import CORNERS
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.tag_reader import Tag, read_tags, tag_pose
from handcart.robotics.perception.objects.upright_fit import TagView, UprightFit, fit_upright

from .object_kind import ObjectKind
from .objects_file import ObjectsFile
from .surface import ObjectSurface

HEIGHT_SIGMA_M = 0.003  # of a surface's height, as the robot knows it
MAX_TILT_RAD = math.radians(30.0)  # of a single view: beyond, the object has fallen over
MAX_RMS_PX = 2.0  # of the fit of an upright object
MAX_APART_M = 0.03  # between two views of one object
ARM_SIGMA_M, ARM_SIGMA_RAD = 1e-3, 3e-3  # of the camera's pose, from view to view


class ReadTag(NamedTuple):
    """A tag that was read, known or not."""

    tag: Tag
    label: str
    """Family and number, in words."""
    object: str | None
    """Object that has it; None if no object has."""
    view: TagView | None
    base_T_object: Transform | None
    """(4, 4) by this picture alone."""


def read_objects(
    image: ByteArray, camera: CameraModel, base_T_camera: Transform, file: ObjectsFile
) -> list[ReadTag]:
    """Return all tags in a picture that belong to a family of the file, in the order of their numbers."""
    owners = {tag.key: (name, tag) for name in file.objects for tag in file.tags_of(name)}
    found: list[ReadTag] = []
    for family in dict.fromkeys(family for family, _ in owners):
        for read in read_tags(image, family=family):
            label = f"tag {family} {read.id}"
            if (family, read.id) not in owners:
                found.append(ReadTag(read, label, None, None, None))
                continue
            name, tag = owners[family, read.id]
            object_T_tag = tag.on_box(file.kind_of(name).size)
            view = TagView(camera, base_T_camera, read.corners, apply(object_T_tag, CORNERS * tag.side))
            pose = base_T_camera @ tag_pose(read, camera, tag.side) @ inverse(object_T_tag)
            found.append(ReadTag(read, label, name, view, np.asarray(pose)))
    return found


class Located(NamedTuple):
    """An object that stands upright on a surface."""

    base_T_object: Transform
    """(4, 4)."""
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad], in the base frame."""
    rms_px: float


class NotUpright(NamedTuple):
    """An object that does not stand on the surface; says why."""

    reason: str


class SeenTwice(NamedTuple):
    """Tags of one object at places that exclude each other."""

    apart: float
    """Distance between them, in [m]."""


def locate(
    reads: Sequence[ReadTag], kind: ObjectKind, surface: ObjectSurface
) -> Located | NotUpright | SeenTwice:
    """Return where an object is, by all its tags that were read.

    Args:
        reads: at least one, all of the same object.
        kind: its kind.
        surface: surface that it should stand on.
    """
    poses = [each.base_T_object for each in reads if each.base_T_object is not None]
    views = [each.view for each in reads if each.view is not None]
    middles = np.array([pose[:3, 3] for pose in poses])
    apart = float(np.linalg.norm(middles - np.median(middles, axis=0), axis=1).max())
    if apart > MAX_APART_M:
        return SeenTwice(apart)
    tilt = float(np.median([math.acos(min(1.0, max(-1.0, pose[2, 2]))) for pose in poses]))
    if tilt > MAX_TILT_RAD:
        return NotUpright(f"it is tilted by {math.degrees(tilt):.0f} deg")
    fit = fit_upright(views, poses[-1], surface.height_m, HEIGHT_SIGMA_M)
    if fit.rms_px > MAX_RMS_PX:
        return NotUpright(f"its tags are {fit.rms_px:.1f} px off where they would be on the surface")
    return Located(fit.base_T_box, _with_arm(fit), fit.rms_px)


def _with_arm(fit: UprightFit) -> FloatArray:
    kept = [0, 1, 3]
    by_arm = np.diag([ARM_SIGMA_M, ARM_SIGMA_M, ARM_SIGMA_RAD]) ** 2
    return np.asarray(fit.covariance[np.ix_(kept, kept)] + by_arm)
