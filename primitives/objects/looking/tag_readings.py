"""Objects in pictures, by their tags."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.description.things.printed_tag import UNIT_TAG_CORNERS
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.tag_reader import Tag, TagPose, read_tags, tag_poses
from handcart.robotics.perception.objects.upright_fit import TagView, UprightFit, fit_upright

HEIGHT_SIGMA_M = 0.003  # of a surface's height, as the robot knows it
MAX_TILT_RAD = math.radians(30.0)  # of a single view: beyond, the object has fallen over
MAX_RMS_PX = 2.0  # of the fit of an upright object
MAX_APART_M = 0.03  # between two views of one object
AMBIGUOUS_RMS_PX = 0.35  # of a tag's corners: a pose that fits so well may be the true one
AMBIGUOUS_RATIO = 2.0  # likewise, of its rms to that of the pose that fits best: some pictures are worse
MIN_UPRIGHT_GAIN = 0.02  # of the cosine of an object's tilt; a tag on a side may be turned about the vertical
MIN_DESCENT = 0.2  # of a line of sight, to a metre along it
ARM_SIGMA_M, ARM_SIGMA_RAD = 1e-3, 3e-3  # of the camera's pose, from view to view


class ReadTag(NamedTuple):
    """Tag that was read in a picture, whether or not a known object has this tag."""

    tag: Tag
    label: str
    """Family and number, in words."""
    object: str | None
    """Name of the object that has the tag; None if no known object has it."""
    view: TagView | None
    base_T_object: Transform | None
    """Pose (4, 4) of the object by this picture alone, in the base frame."""


def read_objects(
    image: ByteArray, camera: CameraModel, base_T_camera: Transform, file: ObjectsFile
) -> list[ReadTag]:
    """Return all tags in a picture that belong to a tag family used in the file, in the order of their
    numbers.

    Args:
        image: (height, width), grey.
        camera: model of the camera.
        base_T_camera: (4, 4) pose of the optical frame.
        file: objects and their tags.
    """
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
            view = TagView(
                camera, base_T_camera, read.corners, apply(object_T_tag, UNIT_TAG_CORNERS * tag.side)
            )
            try:
                poses = tag_poses(read, camera, tag.side)
            except ValueError:  # its corners are seen through the lens where its model is not valid
                found.append(ReadTag(read, label, None, None, None))
                continue
            found.append(ReadTag(read, label, name, view, _likelier(poses, base_T_camera, object_T_tag)))
    return found


def _likelier(poses: Sequence[TagPose], base_T_camera: Transform, object_T_tag: Transform) -> Transform:
    """Return base_T_object (4, 4) by the pose of its tag that fits best.

    Where another pose fits within the corners' errors too, and has the object clearly nearer to upright, that
    one is returned.
    """
    limit = max(AMBIGUOUS_RMS_PX, AMBIGUOUS_RATIO * poses[0].rms_px)
    fitting = [tag_pose for number, tag_pose in enumerate(poses) if number == 0 or tag_pose.rms_px < limit]
    tag_T_object = inverse(object_T_tag)
    found = [np.asarray(base_T_camera @ item.camera_T_tag @ tag_T_object) for item in fitting]
    nearest = max(found, key=lambda pose: float(pose[2, 2]))
    return nearest if nearest[2, 2] > found[0][2, 2] + MIN_UPRIGHT_GAIN else found[0]


class Located(NamedTuple):
    """Measured pose of an object that was found upright on a surface, with its accuracy."""

    base_T_object: Transform
    """Pose (4, 4) of the object in the base frame."""
    covariance: FloatArray
    """(3, 3) of x, y in [m] and heading in [rad], in the base frame."""
    rms_px: float


class NotUpright(NamedTuple):
    """Result of `locate` for an object that is not upright on the surface, with the reason."""

    reason: str


class SeenTwice(NamedTuple):
    """Result of `locate` if two tags of the same object were read at places too far apart for one object."""

    apart: float
    """Distance between them, in [m]."""


def locate(
    reads: Sequence[ReadTag], kind: ObjectKind, surface: ObjectSurface
) -> Located | NotUpright | SeenTwice:
    """Return where an object is, by all its tags that were read; or that it is not upright on the surface, or
    that its tags were read too far apart for one object.

    Args:
        reads: at least one tag that was read, all of the same object.
        kind: kind of the object.
        surface: surface that the object should be on.
    """
    poses = [read.base_T_object for read in reads if read.base_T_object is not None]
    views = [read.view for read in reads if read.view is not None]
    middles = np.array(
        [_on_height(pose, view, surface.height_m) for pose, view in zip(poses, views, strict=True)]
    )
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


def _on_height(base_T_object: Transform, view: TagView, height: float) -> FloatArray:
    """Return the place (3,) of an object's foot in the base frame, in [m], at a height on the line of sight
    to its tag.

    From afar a single picture of a tag determines the distance least. If the line of sight is level, it never
    meets that height, and the place stays as seen.
    """
    foot, tag = base_T_object[:3, 3], apply(base_T_object, view.on_box.mean(axis=0)[None])[0]
    sight = tag - view.base_T_camera[:3, 3]
    if abs(sight[2]) < MIN_DESCENT * np.linalg.norm(sight):
        return foot
    return np.asarray(foot + sight * (height - foot[2]) / sight[2])


def _with_arm(fit: UprightFit) -> FloatArray:
    kept = [0, 1, 3]
    by_arm = np.diag([ARM_SIGMA_M, ARM_SIGMA_M, ARM_SIGMA_RAD]) ** 2
    return np.asarray(fit.covariance[np.ix_(kept, kept)] + by_arm)
