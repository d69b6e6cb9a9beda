"""Checks of the lidar's mounting and of the stability of the base."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ros2.wire.frame_tree import lidar_pose
from handcart.backends.urdf.driven_wheels import driven_wheels
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.urdf_contents import bodies_of, joints_of, link_names, links_of
from handcart.robotics.kinematics.urdf_frames import base_T_frame, link_poses
from handcart.robotics.kinematics.urdf_mounts import joints_above
from handcart.robotics.numerics.arrays import FloatArray

from .masses import corners_of
from .remark import Remark

MIN_HEIGHT_M = 0.02  # of a lidar above the floor
MAX_TILT_DEG = 3.0  # of its plane against the floor
FOOT_TOLERANCE_M = 0.01  # above the lowest wheel, within which a body touches the floor
MIN_SECTOR_DEG = 0.5  # smallest sector of the robot itself that is reported
MARGIN_M = 0.005  # from the centre of mass to the edge of the support polygon


def mount_remarks(robot: RobotFile) -> list[Remark]:
    """Return remarks on a lidar that is too low, tilted or hidden, and on a base that may tip over."""
    urdf = robot.urdf_text()
    if "base" not in link_names(urdf):
        return []
    found = (
        list(_lidar_remarks(robot, urdf))
        if robot.range_sensor and robot.lidar_link in link_names(urdf)
        else []
    )
    return found + list(_standing_remarks(urdf))


def _lidar_remarks(robot: RobotFile, urdf: str) -> Iterator[Remark]:
    mount, place = base_T_frame(urdf, robot.lidar_link), robot.whole.finding("link", robot.lidar_link, "")
    height, upright = float(mount[2, 3]), float(mount[2, 2])
    subject = f"link {robot.lidar_link!r}"
    if height < MIN_HEIGHT_M:
        where = f"{height:.3f} m above the floor" if height >= 0.0 else f"{-height:.3f} m below the floor"
        wrong = f"the lidar is {where}: it sees nothing that the base may run into; needed: its true frame"
        yield Remark(subject, wrong, place)
        return
    if upright < 0.0:
        wrong = "the lidar is mounted upside down: its beams run clockwise; turn the frame upright"
        mends = "reverse the order of the ranges (over ROS 2 by `upside_down: true` under `ros2: lidar`)"
        yield Remark(subject, f"{wrong}, and {mends}", place)
    tilt = math.degrees(math.acos(min(1.0, abs(upright))))
    if tilt > MAX_TILT_DEG:
        wrong = f"the lidar's plane is tilted by {tilt:.0f} deg; allowed: parallel to the floor"
        yield Remark(subject, wrong, place)
    for link, points in _slices(robot, urdf, lidar_pose(mount, is_upside_down=False)):
        hidden = hidden_sector(points)
        if hidden is None:
            yield Remark(subject, f"the lidar is inside a collision body of the link {link!r}", place)
        elif _is_seen(robot, hidden):
            yield Remark(subject, _sector_words(link, hidden), place)


def hidden_links(robot: RobotFile) -> list[tuple[str, tuple[float, float]]]:
    """Return the links fixed to the base that the robot's lidar sees, each with the sector of angles that it
    covers, in [rad].

    The arm is not included, because it moves, and neither is a link that encloses the lidar, such as its
    housing.
    """
    urdf = robot.urdf_text()
    if robot.range_sensor is None or not {"base", robot.lidar_link} <= set(link_names(urdf)):
        return []
    mount = lidar_pose(base_T_frame(urdf, robot.lidar_link), is_upside_down=False)
    slices = _slices(robot, urdf, mount)
    sectors = ((link, hidden_sector(points)) for link, points in slices)
    return [(link, item) for link, item in sectors if item is not None and _is_seen(robot, item)]


def whole_degrees(sector: tuple[float, float]) -> tuple[int, int]:
    """Convert a sector in [rad] to whole degrees, rounded outwards, for the key `masked_deg` of a lidar.

    An end above 180 degrees is returned minus 360.
    """
    start, end = math.floor(math.degrees(sector[0])), math.ceil(math.degrees(sector[1]))
    return start, end if end <= 180 else end - 360


def hidden_sector(points: FloatArray) -> tuple[float, float] | None:
    """Return the bearings in [rad] between which a convex outline hides the surroundings.

    Args:
        points: (n, 2) in the sensor frame, in [m], whose convex hull is the outline.

    Returns:
        Start and end, counter-clockwise; None if the sensor is inside the outline.
    """
    bearings = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    gaps = np.diff(np.append(bearings, bearings[0] + 2.0 * math.pi))
    widest = int(np.argmax(gaps))
    if gaps[widest] < math.pi:
        return None
    start = float(bearings[(widest + 1) % len(bearings)])
    return start, start + 2.0 * math.pi - float(gaps[widest])


def _slices(robot: RobotFile, urdf: str, mount: Transform) -> Iterator[tuple[str, FloatArray]]:
    """Yield links fixed to the base, each with a body's outline (n, 2) in the lidar's plane, in its frame in
    [m].

    Args:
        robot: the robot's file.
        urdf: text of the URDF.
        mount: (4, 4) base_T_sensor of the lidar, upright.
    """
    own = {*(robot.arm.joints if robot.arm else ()), "left_finger", "right_finger"}
    poses, sensor_T_base = link_poses(urdf), inverse(mount)
    base_T_root = inverse(poses["base"])
    for body in bodies_of(urdf):
        if own & set(joints_above(urdf, body.name)):
            continue
        sensor_T_link = sensor_T_base @ base_T_root @ poses[body.name]
        points = corners_of(body) @ sensor_T_link[:3, :3].T + sensor_T_link[:3, 3]
        above, below = points[points[:, 2] >= 0.0], points[points[:, 2] < 0.0]
        if len(above) and len(below):
            share = (above[:, None, 2] / (above[:, None, 2] - below[None, :, 2]))[..., None]
            outline = above[:, None, :2] + share * (below[None, :, :2] - above[:, None, :2])
            yield body.name, outline.reshape(-1, 2)


def _is_seen(robot: RobotFile, sector: tuple[float, float]) -> bool:
    """Return whether a beam that is not masked meets a sector."""
    assert robot.range_sensor is not None
    angles = robot.range_sensor.angles()
    looking = angles[~robot.range_sensor.masked(angles)]
    within = np.mod(looking - sector[0], 2.0 * math.pi) <= sector[1] - sector[0]
    return bool(within.any()) and math.degrees(sector[1] - sector[0]) > MIN_SECTOR_DEG


def _sector_words(link: str, sector: tuple[float, float]) -> str:
    start, end = math.floor(math.degrees(sector[0])), math.ceil(math.degrees(sector[1]))
    masked = [list(whole_degrees(sector))]
    return (
        f"the lidar sees the link {link!r} of the robot itself from {start} to {end} deg; "
        f"if so, `range_sensor: masked_deg: {masked}`"
    )


def _standing_remarks(urdf: str) -> Iterator[Remark]:
    """Yield a remark if the base tips over in simulations with gravity."""
    names = [joint.name for joint in joints_of(urdf)]
    wheels = set(driven_wheels(names).all)
    feet = _feet(urdf, {joint.child for joint in joints_of(urdf) if joint.name in wheels})
    middle = _middle_of_mass(urdf)
    if not wheels or feet is None or middle is None or _stands(feet, middle):
        return
    wrong = f"the base stands on {len(feet)} points of its wheels and casters"
    allowed = "add links with 'caster' in their names that reach down to the floor"
    at = f"({middle[0]:.3f}, {middle[1]:.3f}) m"
    yield Remark("", f"{wrong}, its middle of mass {at} is not above them: with physics it tips; {allowed}")


def _feet(urdf: str, wheels: set[str]) -> FloatArray | None:
    """Return the points (n, 2) where bodies touch the floor, in [m] in the base frame; None without wheel
    bodies.
    """
    poses = link_poses(urdf)
    lowest: list[tuple[str, FloatArray]] = []
    for body in bodies_of(urdf):
        base_T_link = inverse(poses["base"]) @ poses[body.name]
        points = corners_of(body) @ base_T_link[:3, :3].T + base_T_link[:3, 3]
        low = points[points[:, 2] <= points[:, 2].min() + 1e-3]
        lowest.append((body.name, low))
    floors = [float(low[:, 2].min()) for name, low in lowest if name in wheels]
    if not floors:
        return None
    floor = min(floors)
    return np.vstack([low[:, :2] for _, low in lowest if low[:, 2].min() <= floor + FOOT_TOLERANCE_M])


def _middle_of_mass(urdf: str) -> FloatArray | None:
    """Return the robot's centre of mass (2,) in [m] in the base frame, joints at zero; None without any
    mass.
    """
    poses = link_poses(urdf)
    masses = [(link.mass, poses[link.name], link.middle) for link in links_of(urdf) if link.mass]
    if not masses:
        return None
    middles = np.array([(pose @ np.append(middle, 1.0))[:3] for _, pose, middle in masses])
    middle = np.average(middles, axis=0, weights=[mass for mass, _, _ in masses])
    return np.asarray((inverse(poses["base"]) @ np.append(middle, 1.0))[:2])


def _stands(feet: FloatArray, middle: Sequence[float] | FloatArray) -> bool:
    """Return whether a point (2,) is inside the convex hull of the feet (n, 2), both in the base frame in
    [m].
    """
    try:
        hull = ConvexHull(feet)
    except QhullError:  # on a line
        return False
    return bool((hull.equations[:, :2] @ middle + hull.equations[:, 2] <= -MARGIN_M).all())
