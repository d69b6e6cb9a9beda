"""Markers of a run for RViz and Foxglove."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.serving_link import ServingLink
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .seen_state import SeenState

MAP_FRAME = "map"
MARKER_KIND, MARKERS_KIND = "visualization_msgs/Marker", "visualization_msgs/MarkerArray"
ARROW, LINE_STRIP, SPHERE_LIST, TEXT = 0, 4, 7, 9
ADD, DELETE = 0, 2
PERSON_DIAMETER_M, POINT_DIAMETER_M, LINE_WIDTH_M, TEXT_HEIGHT_M = 0.5, 0.06, 0.03, 0.15
TEXT_ABOVE_M = 1.2

Colour = tuple[float, float, float]
BLUE, GREY, RED, ORANGE, GREEN = (
    (0.1, 0.4, 0.9),
    (0.5,) * 3,
    (0.9, 0.1, 0.1),
    (1.0, 0.6, 0.0),
    (0.1, 0.7, 0.2),
)


class Layer(NamedTuple):
    """Appearance of one kind of points or lines, such as the planned path, that are published as ROS
    markers.
    """

    name: str
    type: int
    size_m: float
    colour: Colour


PLANNED_LAYER = Layer("planned", LINE_STRIP, LINE_WIDTH_M, BLUE)
DRIVEN_LAYER = Layer("driven", LINE_STRIP, LINE_WIDTH_M, GREY)
FELT_LAYER = Layer("felt", SPHERE_LIST, POINT_DIAMETER_M, RED)
PEOPLE_LAYER = Layer("people", SPHERE_LIST, PERSON_DIAMETER_M, ORANGE)


def marker_array(link: ServingLink, seen: SeenState, status: str, residuals: str) -> Any:
    """Return a ROS `MarkerArray` that shows the state of a run, for RViz.

    Args:
        link: connection to ROS 2, which creates the messages.
        seen: state of the run.
        status: text shown above the robot.
        residuals: text with the errors left after the last failed action was undone, shown at the pose that
            the action started from; "" for none.
    """
    message = link.message(MARKERS_KIND)
    message.markers = list(_markers(link, seen, status, residuals))
    return message


def _markers(link: ServingLink, seen: SeenState, status: str, residuals: str) -> Iterator[Any]:
    yield _points(link, PLANNED_LAYER, seen.planned)
    yield _points(link, DRIVEN_LAYER, seen.driven)
    yield _points(link, FELT_LAYER, seen.felt)
    yield _points(link, PEOPLE_LAYER, seen.people[:, :2])
    yield _arrow(link, "pose", seen.pose, GREEN)
    yield _arrow(link, "snapshot", seen.snapshot, BLUE)
    yield _text(link, "status", seen.pose, status)
    yield _text(link, "residuals", seen.snapshot, residuals)


def _marker(link: ServingLink, name: str, type_: int, colour: Colour, shown: bool) -> Any:
    marker = link.message(MARKER_KIND)
    marker.header.frame_id = MAP_FRAME
    set_stamp(marker.header, link.now())
    marker.ns, marker.id, marker.type, marker.action = name, 0, type_, ADD if shown else DELETE
    marker.color.r, marker.color.g, marker.color.b = colour
    marker.color.a, marker.pose.orientation.w = 1.0, 1.0
    return marker


def _points(link: ServingLink, layer: Layer, points: FloatArray) -> Any:
    finite = points[np.isfinite(points).all(axis=1)]
    least = 2 if layer.type == LINE_STRIP else 1
    marker = _marker(link, layer.name, layer.type, layer.colour, len(finite) >= least)
    marker.scale.x = marker.scale.y = marker.scale.z = layer.size_m
    marker.points = [_point(link, x, y, 0.05) for x, y in finite.tolist()]
    return marker


def _arrow(link: ServingLink, name: str, pose: Pose2 | None, colour: Colour) -> Any:
    marker = _marker(link, name, ARROW, colour, _is_finite(pose))
    marker.scale.x, marker.scale.y, marker.scale.z = 0.4, 0.06, 0.06
    _place(marker, pose, 0.05)
    return marker


def _text(link: ServingLink, name: str, pose: Pose2 | None, words: str) -> Any:
    marker = _marker(link, name, TEXT, (1.0, 1.0, 1.0), bool(words) and _is_finite(pose))
    marker.scale.z, marker.text = TEXT_HEIGHT_M, words
    _place(marker, pose, TEXT_ABOVE_M)
    return marker


def _place(marker: Any, pose: Pose2 | None, height: float) -> None:
    if pose is None or not _is_finite(pose):
        return
    place, turn = marker.pose.position, marker.pose.orientation
    place.x, place.y, place.z = float(pose.x), float(pose.y), height
    turn.z, turn.w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)


def _point(link: ServingLink, x: float, y: float, z: float) -> Any:
    point = link.message("geometry_msgs/Point")
    point.x, point.y, point.z = x, y, z
    return point


def _is_finite(pose: Pose2 | None) -> bool:
    return pose is not None and all(map(math.isfinite, (pose.x, pose.y, pose.theta)))


def pose_message(link: ServingLink, pose: Pose2, covariance: FloatArray) -> Any:
    """Return a `PoseWithCovarianceStamped` of map_T_base; `covariance` (3, 3) of x, y [m], heading [rad]."""
    message = link.message("geometry_msgs/PoseWithCovarianceStamped")
    message.header.frame_id = MAP_FRAME
    set_stamp(message.header, link.now())
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    place.x, place.y = float(pose.x), float(pose.y)
    turn.z, turn.w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    full = np.zeros((6, 6))
    full[np.ix_((0, 1, 5), (0, 1, 5))] = covariance
    message.pose.covariance = full.ravel().tolist()
    return message


def path_message(link: ServingLink, points: FloatArray) -> Any:
    """Return a `nav_msgs/Path` through points (n, 2) on the map, in [m]."""
    message = link.message("nav_msgs/Path")
    message.header.frame_id = MAP_FRAME
    set_stamp(message.header, link.now())
    message.poses = [_path_pose(link, xy, message.header) for xy in points.tolist()]
    return message


def _path_pose(link: ServingLink, xy: Sequence[float], header: Any) -> Any:
    pose = link.message("geometry_msgs/PoseStamped")
    pose.header = header
    pose.pose.position.x, pose.pose.position.y = xy
    pose.pose.orientation.w = 1.0
    return pose
