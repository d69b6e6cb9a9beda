"""Export of a recorded run as MCAP with Foxglove's schemas, readable by Foxglove, Rerun and others."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from handcart.evaluation.viewing.playback.playback import Playback
from handcart.evaluation.viewing.playback.scenery import RobotShape
from handcart.evaluation.viewing.playback.seven import on_floor, seven, sevens, transforms
from handcart.evaluation.viewing.view.rays import height_of
from handcart.files.whole_file import write_whole
from handcart.files.xml_file import checked_xml
from handcart.networks.past_runs.past_run import PastRun
from handcart.networks.run_files.run_folder import read_file
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.urdf_assembly import root_link
from handcart.robotics.kinematics.urdf_frames import link_poses
from handcart.robotics.numerics.arrays import FloatArray, Int8Array

from .events import event_messages
from .scene import on_map, scene_messages
from .stamped import MAP_FRAME, Message, nanoseconds, orientation_of, pose_of, position_of, stamp

if TYPE_CHECKING:
    from foxglove.messages import FrameTransforms, Grid, JointStates, LaserScan

CAMERA_FRAME, LIDAR_FRAME = "camera", "range_sensor"
"""Names of the sensors' frames."""
BASE_LINK = "base"
"""Link of the URDF whose pose is estimated; the root link, which may be another one, carries it."""
FINGER_JOINTS = ("left_finger", "right_finger")
"""Finger joints, each at half the gripper's opening, if the URDF has them."""
MAX_SUMMARY_BYTES = 64 * 2**20
FREE_CELL, OCCUPIED_CELL, UNKNOWN_CELL = 0, 100, -1
"""Cell values of an occupancy grid, as in ROS."""


def write_mcap(recorded: Playback, path: Path) -> dict[str, int]:
    """Write a recorded run as MCAP; times are the robot's, from 0.

    Args:
        recorded: the run.
        path: path of the file.

    Returns:
        The number of messages of each topic.

    Raises:
        ImportError: the extra `export` is not installed.
        NoRun, BadFile: a file in the run's folder is damaged.
        OSError: the file cannot be written.
    """
    import foxglove

    context, content, counts = foxglove.Context(), io.BytesIO(), Counter[str]()
    with foxglove.open_mcap(content, context=context) as writer:
        writer.write_metadata("handcart", _about(recorded.run))
        for name, kind, data in _attached(recorded):
            writer.attach(log_time=0, create_time=0, name=name, media_type=kind, data=data)
        channels: dict[str, Any] = {}
        for time, topic, message in sorted(_messages(recorded), key=lambda item: item[0]):
            if topic not in channels:
                channel = getattr(foxglove.channels, f"{type(message).__name__}Channel")
                channels[topic] = channel(topic, context=context)
            channels[topic].log(message, log_time=nanoseconds(time))
            counts[topic] += 1
    write_whole(path, content.getvalue())
    return dict(counts)


def _messages(recorded: Playback) -> Iterator[Message]:
    if recorded.scenery.map is not None:
        yield recorded.start, "/map", _grid(recorded)
    yield from _bases(recorded)
    yield from _sensed(recorded)
    yield from scene_messages(recorded)
    yield from event_messages(recorded.run)


def _bases(recorded: Playback) -> Iterator[Message]:
    """Yield the estimated and the true poses of the base, and the particles."""
    from foxglove.messages import PoseInFrame, PosesInFrame

    rows, frames = recorded.rows, robot_frames(recorded.scenery.robot)
    truth = on_map(recorded, rows.truth)
    roots, known = np.full((len(rows.pose), 7), np.nan), np.isfinite(rows.pose).all(axis=1)
    roots[known] = sevens(transforms(on_floor(rows.pose[known])) @ frames.base_T_root)
    for row, time in enumerate(rows.time.tolist()):
        believed = pose_of(rows.pose[row])
        yield time, "/tf", _transforms(time, roots[row], frames)
        yield time, "/pose", PoseInFrame(timestamp=stamp(time), frame_id=MAP_FRAME, pose=believed)
        if np.isfinite(rows.truth[row]).all():
            true = pose_of(truth[row])
            yield time, "/truth", PoseInFrame(timestamp=stamp(time), frame_id=MAP_FRAME, pose=true)
    for time, cloud in zip(rows.cloud_time.tolist(), rows.cloud, strict=True):
        poses = [pose_of(item) for item in cloud]
        yield time, "/particles", PosesInFrame(timestamp=stamp(time), frame_id=MAP_FRAME, poses=poses)


def _sensed(recorded: Playback) -> Iterator[Message]:
    from foxglove.messages import CompressedImage

    rows, known = recorded.rows, {item.get("name") for item in _urdf(recorded).iter("joint")}
    if recorded.scenery.robot.joints:
        fingers = known.issuperset(FINGER_JOINTS)
        for row, time in enumerate(rows.time.tolist()):
            yield time, "/joint_states", _joints(recorded, row, fingers)
    for number, time in enumerate(rows.scan_time.tolist()):
        yield time, "/scan", _scan(recorded, number, time)
    for time, jpeg in zip(rows.picture_time.tolist(), recorded.pictures, strict=True):
        image = CompressedImage(timestamp=stamp(time), frame_id=CAMERA_FRAME, data=jpeg, format="jpeg")
        yield time, "/camera", image


class RobotFrames(NamedTuple):
    """Root link of a robot's URDF, with its pose on the base and the lidar's pose on it."""

    root: str
    base_T_root: Transform
    """(4, 4) pose of the root link in the frame of the base."""
    root_T_lidar: FloatArray
    """(7,) pose of the lidar in the root link: x, y, z in [m], and a unit quaternion w, x, y, z."""


def robot_frames(robot: RobotShape) -> RobotFrames:
    """Return the frames of a recorded robot; without a link `base`, the root link is the base."""
    root = root_link(ElementTree.fromstring(checked_xml(robot.urdf.encode(), "the recorded URDF")))
    poses = link_poses(robot.urdf)
    root_T_base = poses.get(BASE_LINK, np.eye(4))
    x, y, heading = robot.base_t_sensor
    base_T_lidar = transform((x, y, height_of(robot.urdf)), (0.0, 0.0, heading))
    return RobotFrames(root, inverse(root_T_base), np.array(seven(root_T_base @ base_T_lidar)))


def _transforms(time: float, map_T_root: FloatArray, frames: RobotFrames) -> FrameTransforms:
    """Return the transforms of the robot on the map and of the lidar on the robot.

    Args:
        time: of the transforms, in [s].
        map_T_root: (7,) pose of the root link on the map, as in `RobotFrames.root_T_lidar`.
        frames: the robot's frames.
    """
    from foxglove.messages import FrameTransform, FrameTransforms

    at = stamp(time)
    links = ((MAP_FRAME, frames.root, map_T_root), (frames.root, LIDAR_FRAME, frames.root_T_lidar))
    return FrameTransforms(
        transforms=[
            FrameTransform(
                timestamp=at,
                parent_frame_id=parent,
                child_frame_id=child,
                translation=position_of(pose),
                rotation=orientation_of(pose),
            )
            for parent, child, pose in links
        ]
    )


def _joints(recorded: Playback, row: int, fingers: bool) -> JointStates:
    from foxglove.messages import JointState, JointStates

    rows, names = recorded.rows, recorded.scenery.robot.joints
    found = dict(zip(names, rows.joints[row].tolist(), strict=True))
    if fingers:
        found |= dict.fromkeys(FINGER_JOINTS, 0.5 * float(rows.width[row]))
    states = [JointState(name=name, position=value) for name, value in found.items()]
    return JointStates(timestamp=stamp(float(rows.time[row])), joints=states)


def _scan(recorded: Playback, number: int, time: float) -> LaserScan:
    from foxglove.messages import LaserScan

    angles = recorded.scenery.robot.angles_rad
    return LaserScan(
        timestamp=stamp(time),
        frame_id=LIDAR_FRAME,
        start_angle=angles[0] if angles else 0.0,
        end_angle=angles[-1] if angles else 0.0,
        ranges=recorded.ranges(number).tolist(),
    )


def _grid(recorded: Playback) -> Grid:
    from foxglove.messages import Grid, PackedElementField, PackedElementFieldNumericType, Vector2

    shape = recorded.scenery.map
    assert shape is not None
    picture = shape.picture()[::-1]
    cells: Int8Array = np.full(picture.shape, UNKNOWN_CELL, np.int8)
    cells[picture == 0], cells[picture == 255] = OCCUPIED_CELL, FREE_CELL
    kind = PackedElementFieldNumericType.Int8
    columns = int(picture.shape[1])
    return Grid(
        timestamp=stamp(recorded.start),
        frame_id=MAP_FRAME,
        pose=pose_of(np.array([*shape.origin_m, 0.0])),
        column_count=columns,
        cell_size=Vector2(x=shape.resolution_m, y=shape.resolution_m),
        row_stride=columns,
        cell_stride=1,
        fields=[PackedElementField(name="occupancy", offset=0, type=kind)],
        data=cells.tobytes(),
    )


def _urdf(recorded: Playback) -> ElementTree.Element:
    return ElementTree.fromstring(checked_xml(recorded.scenery.robot.urdf.encode(), "the recorded URDF"))


def _about(run: PastRun) -> dict[str, str]:
    said, end = run.header, run.end or {}
    named = {key: str(said[key]) for key in ("task", "task_path", "robot", "backend", "seed", "handcart")}
    return named | {key: str(end.get(key, "")) for key in ("outcome", "reason")}


def _attached(recorded: Playback) -> Iterator[tuple[str, str, bytes]]:
    """Yield name, media type and content of the attached files."""
    yield "robot.urdf", "application/xml", recorded.scenery.robot.urdf.encode()
    summary = read_file(recorded.run.folder, "summary.json", MAX_SUMMARY_BYTES, missing=True)
    if summary is not None:
        yield "summary.json", "application/json", summary
