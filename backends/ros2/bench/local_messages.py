"""Messages with the fields of ROS's that topics within this process carry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any


def new_message(kind: str) -> Any:
    """Return an empty message, such as one of `sensor_msgs/LaserScan`."""
    return _MADE[kind.partition("/")[2]]()


def _header() -> SimpleNamespace:
    return SimpleNamespace(frame_id="", stamp=SimpleNamespace(sec=0, nanosec=0))


def _vector() -> SimpleNamespace:
    return SimpleNamespace(x=0.0, y=0.0, z=0.0)


def _twist() -> SimpleNamespace:
    return SimpleNamespace(linear=_vector(), angular=_vector())


def _odometry() -> SimpleNamespace:
    turn = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    pose = SimpleNamespace(pose=SimpleNamespace(position=_vector(), orientation=turn))
    return SimpleNamespace(
        header=_header(), child_frame_id="", pose=pose, twist=SimpleNamespace(twist=_twist())
    )


def _scan() -> SimpleNamespace:
    angles = {"angle_min": 0.0, "angle_max": 0.0, "angle_increment": 0.0}
    return SimpleNamespace(
        header=_header(), **angles, range_min=0.0, range_max=0.0, ranges=[], intensities=[]
    )


def _image() -> SimpleNamespace:
    form = {"height": 0, "width": 0, "encoding": "", "is_bigendian": 0, "step": 0}
    return SimpleNamespace(header=_header(), **form, data=b"")


def _fix() -> SimpleNamespace:
    place = {"latitude": 0.0, "longitude": 0.0, "altitude": 0.0}
    return SimpleNamespace(
        header=_header(),
        status=SimpleNamespace(status=0, service=0),
        **place,
        position_covariance=[0.0] * 9,
        position_covariance_type=0,
    )


def _camera_info() -> SimpleNamespace:
    lens = {"distortion_model": "", "d": [], "k": [0.0] * 9, "r": [0.0] * 9, "p": [0.0] * 12}
    return SimpleNamespace(header=_header(), height=0, width=0, **lens)


def _frame() -> SimpleNamespace:
    turn = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
    pose = SimpleNamespace(translation=_vector(), rotation=turn)
    return SimpleNamespace(header=_header(), child_frame_id="", transform=pose)


def _duration() -> SimpleNamespace:
    return SimpleNamespace(sec=0, nanosec=0)


def new_goal(kind: str) -> Any:
    """Return an empty goal of an action, such as one of `control_msgs/GripperCommand`."""
    if kind.endswith("GripperCommand"):
        return SimpleNamespace(command=SimpleNamespace(position=0.0, max_effort=0.0))
    tolerances = {"path_tolerance": [], "goal_tolerance": [], "goal_time_tolerance": _duration()}
    return SimpleNamespace(trajectory=new_message("trajectory_msgs/JointTrajectory"), **tolerances)


def new_result(kind: str) -> Any:
    """Return an empty result message of an action, such as one of `control_msgs/GripperCommand`."""
    if kind.endswith("GripperCommand"):
        return SimpleNamespace(position=0.0, effort=0.0, stalled=False, reached_goal=False)
    return SimpleNamespace(error_code=0, error_string="")


_MADE: Mapping[str, Callable[[], SimpleNamespace]] = {
    "Twist": _twist,
    "TwistStamped": lambda: SimpleNamespace(header=_header(), twist=_twist()),
    "Odometry": _odometry,
    "JointState": lambda: SimpleNamespace(header=_header(), name=[], position=[], velocity=[], effort=[]),
    "LaserScan": _scan,
    "Image": _image,
    "String": lambda: SimpleNamespace(data=""),
    "CameraInfo": _camera_info,
    "NavSatFix": _fix,
    "Imu": lambda: SimpleNamespace(
        header=_header(), angular_velocity=_vector(), linear_acceleration=_vector()
    ),
    "WrenchStamped": lambda: SimpleNamespace(
        header=_header(), wrench=SimpleNamespace(force=_vector(), torque=_vector())
    ),
    "JointTrajectory": lambda: SimpleNamespace(header=_header(), joint_names=[], points=[]),
    "JointTrajectoryPoint": lambda: SimpleNamespace(positions=[], velocities=[], time_from_start=_duration()),
    "TFMessage": lambda: SimpleNamespace(transforms=[]),
    "TransformStamped": lambda: SimpleNamespace(
        header=_header(),
        child_frame_id="",
        transform=SimpleNamespace(
            translation=_vector(), rotation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
        ),
    ),
    "Float64MultiArray": lambda: SimpleNamespace(data=[]),
}
