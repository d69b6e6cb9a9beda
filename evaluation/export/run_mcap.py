"""A run as MCAP, in Foxglove's schemas: for Foxglove, Rerun, and whoever reads MCAP."""

from __future__ import annotations

import hashlib
import io
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_loading import load_robot
from handcart.files.errors import HandcartError
from handcart.files.maps.map_file import load_map
from handcart.files.whole_file import write_whole
from handcart.networks.journal.past_run import PastRun, Record
from handcart.networks.runs.run_folder import read_file
from handcart.networks.task.task_file import load_task
from handcart.robotics.navigation.maps.grid_map import GridMap

from .recorded import Joints, Picture, Recorded, Scan

if TYPE_CHECKING:
    from foxglove.messages import (
        CompressedImage,
        Grid,
        JointStates,
        LaserScan,
        Log,
        Pose,
        Quaternion,
        Timestamp,
        Vector3,
    )

MAP, BASE, CAMERA = "map", "base", "camera"
"""Names of frames."""
GRIPPER = "gripper"
"""The joint that stands for the opening of the gripper, in [m]."""
MOST = 64 * 2**20  # of a picture, in [bytes]
LEVELS = {"Fail": "Warning", "GiveUp": "Error"}
FREE, OCCUPIED, UNKNOWN = 0, 100, -1
Message = tuple[float, str, Any]
"""When, in [s] of the robot's time; on which topic; and what."""


def write_mcap(run: PastRun, path: Path) -> dict[str, int]:
    """Write what was recorded of a run; times are the robot's, from 0.

    Args:
        run: read back from its folder.
        path: of the file.

    Returns:
        How many messages each topic has.

    Raises:
        ImportError: the extra `export` isn't installed.
        NoRun: something in the run's folder is damaged.
        OSError: the file can't be written.
    """
    import foxglove

    context, content, counts = foxglove.Context(), io.BytesIO(), Counter[str]()
    with foxglove.open_mcap(content, context=context) as writer:
        writer.write_metadata("handcart", _about(run))
        summary = read_file(run.folder, "summary.json", MOST, missing=True)
        if summary is not None:
            writer.attach(
                log_time=0, create_time=0, name="summary.json", media_type="application/json", data=summary
            )
        channels: dict[str, Any] = {}
        for time, topic, message in sorted(_messages(run), key=lambda each: each[0]):
            if topic not in channels:
                kind = getattr(foxglove.channels, f"{type(message).__name__}Channel")
                channels[topic] = kind(topic, context=context)
            channels[topic].log(message, log_time=_nanoseconds(time))
            counts[topic] += 1
    write_whole(path, content.getvalue())
    return dict(counts)


def _messages(run: PastRun) -> Iterator[Message]:
    recorded, names = Recorded(run), _joint_names(run)
    if (grid := _map(run)) is not None:
        yield 0.0, "/map", _grid(grid)
    yield from _poses(run)
    yield from ((each.time, "/scan", _scan(each)) for each in recorded.scans())
    yield from ((each.time, "/joint_states", _joints(each, names)) for each in recorded.joints())
    yield from ((each.time, f"/pictures/{each.name}", _picture(run, each)) for each in recorded.pictures())
    yield from ((float(each["t"]), "/events", _event(each, run)) for each in run.records)


def _poses(run: PastRun) -> Iterator[Message]:
    """Where the base was, of the whole run: for plots, and as the transform of its frame."""
    from foxglove.messages import FrameTransform, FrameTransforms, PoseInFrame

    if run.track is None:
        return
    for time, (x, y, theta) in zip(run.track.time, run.track.pose, strict=True):
        position, orientation = _at(x, y, theta)
        moved = FrameTransform(
            timestamp=_stamp(time),
            parent_frame_id=MAP,
            child_frame_id=BASE,
            translation=position,
            rotation=orientation,
        )
        yield float(time), "/tf", FrameTransforms(transforms=[moved])
        yield float(time), "/pose", PoseInFrame(timestamp=_stamp(time), frame_id=MAP, pose=_pose(x, y, theta))


def _scan(scan: Scan) -> LaserScan:
    from foxglove.messages import LaserScan

    return LaserScan(
        timestamp=_stamp(scan.time),
        frame_id=BASE,
        pose=_pose(*scan.base_T_sensor),
        start_angle=float(scan.angles[0]),
        end_angle=float(scan.angles[-1]),
        ranges=[float(each) for each in scan.ranges],
    )


def _joints(joints: Joints, names: Sequence[str]) -> JointStates:
    from foxglove.messages import JointState, JointStates

    known = names if len(names) == len(joints.joints) else [f"joint_{at}" for at in range(len(joints.joints))]
    states = [
        JointState(name=name, position=float(value)) for name, value in zip(known, joints.joints, strict=True)
    ]
    if joints.grip is not None:
        states.append(JointState(name=GRIPPER, position=float(joints.grip)))
    return JointStates(timestamp=_stamp(joints.time), joints=states)


def _picture(run: PastRun, picture: Picture) -> CompressedImage:
    from foxglove.messages import CompressedImage

    data = read_file(picture.path.parent, picture.path.name, MOST)
    return CompressedImage(timestamp=_stamp(picture.time), frame_id=CAMERA, data=data or b"", format="png")


def _event(record: Record, run: PastRun) -> Log:
    """A record of the journal in words; Fails are warnings, GiveUps errors."""
    from foxglove.messages import Log, LogLevel

    level = LEVELS.get(str(record.get("outcome", "")), "Info")
    words = ": ".join(each for each in _event_words(record, run) if each)
    return Log(
        timestamp=_stamp(float(record["t"])),
        level=getattr(LogLevel, level),
        message=words,
        name=str(record["kind"]),
    )


def _event_words(record: Record, run: PastRun) -> Iterator[str]:
    number = record.get("n")
    if number is not None:
        done = next((each.do for each in run.actions if each.number == number), "")
        yield f"{number}. {done}"
    if record["kind"] == "RUN":
        yield str(record["task"])
    if "action" in record:
        action = record["action"]
        yield f"from {action['from']} to {action['to']}"
    yield from (str(record[key]) for key in ("effect", "outcome", "situation", "reason") if record.get(key))


def _grid(grid: GridMap) -> Grid:
    from foxglove.messages import Grid, PackedElementField, PackedElementFieldNumericType, Vector2

    cells: NDArray[np.int8] = np.full(grid.occupied.shape, FREE, np.int8)
    cells[grid.occupied], cells[grid.unknown] = OCCUPIED, UNKNOWN
    kind = PackedElementFieldNumericType.Int8
    return Grid(
        timestamp=_stamp(0.0),
        frame_id=MAP,
        pose=_pose(grid.origin_x, grid.origin_y, 0.0),
        column_count=cells.shape[1],
        cell_size=Vector2(x=grid.resolution, y=grid.resolution),
        row_stride=cells.shape[1],
        cell_stride=1,
        fields=[PackedElementField(name="occupancy", offset=0, type=kind)],
        data=cells.tobytes(),
    )


def _map(run: PastRun) -> GridMap | None:
    """The task's map; None where it has none, or the task's file isn't what it was."""
    path = Path(run.header["task_path"])
    try:
        if hashlib.sha256(path.read_bytes()).hexdigest() != run.header["task_sha256"]:
            return None
        chart = load_task(path, run.header["settings"]).path("knowledge", "map")
        return None if chart is None else load_map(chart)[0]
    except (OSError, HandcartError):
        return None


def _joint_names(run: PastRun) -> Sequence[str]:
    """As in the robot's URDF; none where its file isn't there any more."""
    try:
        return load_robot(str(run.header["robot"]), drives=False).joint_units.names
    except HandcartError:
        return ()


def _about(run: PastRun) -> dict[str, str]:
    said, end = run.header, run.end or {}
    named = {key: str(said[key]) for key in ("task", "task_path", "robot", "backend", "seed", "handcart")}
    return named | {key: str(end.get(key, "")) for key in ("outcome", "reason")}


def _at(x: float, y: float, theta: float) -> tuple[Vector3, Quaternion]:
    from foxglove.messages import Quaternion, Vector3

    turned = Quaternion(x=0.0, y=0.0, z=math.sin(0.5 * theta), w=math.cos(0.5 * theta))
    return Vector3(x=float(x), y=float(y), z=0.0), turned


def _pose(x: float, y: float, theta: float) -> Pose:
    from foxglove.messages import Pose

    position, orientation = _at(x, y, theta)
    return Pose(position=position, orientation=orientation)


def _stamp(time: float) -> Timestamp:
    from foxglove.messages import Timestamp

    return Timestamp(*divmod(_nanoseconds(time), 1_000_000_000))


def _nanoseconds(time: float) -> int:
    return round(1e9 * time)
