"""What is wrong between the section `ros2` of a robot's file and the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.files.suggest import suggest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from handcart.backends.description.robot_file import RobotFile
    from handcart.backends.description.ros_spec import RosSpec
    from handcart.files.errors import Finding
    from handcart.files.yaml.yaml_document import Document
    from handcart.files.yaml.yaml_node import KeyPath


def ros_findings(robot: RobotFile, document: Document) -> list[Finding]:
    """Return the faults of a robot's section `ros2`, each at its place in the robot's file."""
    if robot.ros2 is None:
        return []
    return [
        document.finding(("ros2", *key), words, at_key=is_key)
        for key, words, is_key in ros_faults(robot, robot.ros2)
    ]


def ros_faults(robot: RobotFile, spec: RosSpec) -> Iterator[tuple[KeyPath, str, bool]]:
    """Yield the faults of a section `ros2`, of joints, cameras and the satellite receiver.

    Each fault consists of the key path below the section, a text, and True if the key itself is wrong, False
    if its value is wrong.
    """
    yield from _joint_faults(robot, spec)
    if robot.gps is not None and spec.gps is None:
        yield (), "gps: the robot has a receiver; needed: origin_lat_deg and origin_lon_deg", False
    yield from _camera_faults(robot, spec)


def _joint_faults(robot: RobotFile, spec: RosSpec) -> Iterator[tuple[KeyPath, str, bool]]:
    """Yield joints that the arm lacks, and those with no controller or with more than one."""
    joints = () if robot.arm is None else robot.arm.joints
    driven: list[tuple[KeyPath, str]] = [
        (("arm", key, name, number), joint)
        for key, controllers in (("controllers", spec.arm.controllers), ("actions", spec.arm.actions))
        for name, own in controllers.items()
        for number, joint in enumerate(own)
    ]
    named = [(path, joint, False) for path, joint in driven]
    named += [(("names", joint), joint, True) for joint in spec.names]
    named += [(("reversed", number), joint, False) for number, joint in enumerate(spec.reversed)]
    for path, joint, is_key in named:
        if joint not in joints:
            yield path, f"the arm has no joint {joint!r}{suggest(joint, joints)}", is_key
    if not driven:  # all joints by the default topic
        return
    for joint in joints:
        paths = [path for path, item in driven if item == joint]
        if not paths:
            yield ("arm",), f"no controller has the joint {joint!r}; needed: one", True
        for path in paths[1:]:
            many = len({path[:3] for path in paths})
            words = f"{many} controllers have the joint {joint!r}; needed: one"
            yield path, words if many > 1 else f"the joint {joint!r} is named twice; allowed: once", False


def _camera_faults(robot: RobotFile, spec: RosSpec) -> Iterator[tuple[KeyPath, str, bool]]:
    """Yield names of cameras that the robot's file lacks, or that have their topic elsewhere."""
    first = None if robot.camera is None else robot.name_of(robot.camera)
    for key, named, kind in (("cameras", spec.cameras, CameraSpec), ("depth", spec.depth, DepthCameraSpec)):
        known = [name for name in robot.all_of(kind) if name != first]
        for name in named:
            if name == first:
                words = f"{name!r} is the first camera; needed: its topic under the key camera"
                yield (key, name), words, True
            elif name not in known:
                words = "camera" if key == "cameras" else "depth camera"
                yield (key, name), f"the robot has no further {words} {name!r}{suggest(name, known)}", True
