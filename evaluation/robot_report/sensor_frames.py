"""Links of a URDF that may be the sensor frames of a robot's file."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from .link_tree import LinkTree

MIN_LEVEL_COSINE = 0.99  # between a lidar's z axis and the vertical
MIN_LIDAR_HEIGHT_M = 0.03  # above the floor
_NAMES = {
    "range_sensor": re.compile(r"laser|lidar|scan|rplidar|hokuyo|sick", re.IGNORECASE),
    "camera": re.compile(r"optical|camera|kinect|xtion|realsense", re.IGNORECASE),
    "imu": re.compile(r"imu", re.IGNORECASE),
    "gps": re.compile(r"gps|gnss", re.IGNORECASE),
}
_OPTICAL = re.compile(r"optical", re.IGNORECASE)
_COLOUR = re.compile(r"rgb|colou?r", re.IGNORECASE)
_OF_A_CAMERA = re.compile(r"rgbd|depth|infra|camera|optical|(?<![a-z])ir(?![a-z])", re.IGNORECASE)
_MOUNT = re.compile(r"mount|screw|bracket|plate|box|support", re.IGNORECASE)


class SensorFrame(NamedTuple):
    """Link of a URDF that is probably the frame of a sensor."""

    link: str
    between: tuple[str, ...]
    """Joints that move it relative to its expected mount: the hand for cameras, otherwise the base."""


def sensor_frames(tree: LinkTree, base: str, hand: str | None) -> dict[str, SensorFrame]:
    """Return the best link for each sensor; sensors without a candidate are omitted.

    Among cameras, those fixed to the hand are preferred, then optical frames, then colour frames. Other
    sensors are expected on the base. A lidar must be level and above the floor, which excludes most links
    that are only auxiliary frames.

    Args:
        tree: links of the robot.
        base: link on the floor.
        hand: link at the arm's end; None without an arm.
    """
    found = {}
    for role, names in _NAMES.items():
        links = [link for link in tree.links if link == role or names.search(link)]
        if role == "range_sensor":
            links = [link for link in links if _scans_level(tree, base, link)]
        onto = hand if role == "camera" else None
        frames = [SensorFrame(link, _between(tree, link, onto)) for link in links]
        if frames:
            found[role] = min(frames, key=_camera_rank if role == "camera" else _rank(role))
    return found


def _scans_level(tree: LinkTree, base: str, link: str) -> bool:
    height = float(tree.pose[link][2, 3] - tree.pose[base][2, 3])
    return abs(float(tree.pose[link][2, 2])) > MIN_LEVEL_COSINE and height > MIN_LIDAR_HEIGHT_M


def _between(tree: LinkTree, link: str, onto: str | None) -> tuple[str, ...]:
    """Return the joints that move one link relative to another, or to the root if that is None."""
    own, other = tree.moved_by(link), [] if onto is None else tree.moved_by(onto)
    return (*(item for item in own if item not in other), *(item for item in other if item not in own))


def _camera_rank(frame: SensorFrame) -> tuple[bool, ...]:
    return (
        frame.link != "camera",
        bool(frame.between),
        not _OPTICAL.search(frame.link),
        not _COLOUR.search(frame.link),
        bool(_MOUNT.search(frame.link)),
    )


def _rank(role: str) -> Callable[[SensorFrame], tuple[bool, ...]]:
    return lambda frame: (
        frame.link != role,
        bool(frame.between),
        bool(_OF_A_CAMERA.search(frame.link)),
        bool(_MOUNT.search(frame.link)),
    )
