"""Topics of a robot's cameras, by their names in its file."""

from __future__ import annotations

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosCameraSpec, RosDepthSpec, RosSpec
from handcart.backends.description.sensor_specs import CameraSpec
from handcart.backends.sensors.depth_spec import DepthCameraSpec


def camera_topics(robot: RobotFile, spec: RosSpec) -> dict[str, tuple[CameraSpec, RosCameraSpec]]:
    """Return the description and the topic of each camera that has a topic in the section `ros2`, by its name
    in the robot's file.
    """
    cameras = robot.all_of(CameraSpec)
    return {
        name: (camera, spec.camera if camera is robot.camera else spec.cameras[name])
        for name, camera in cameras.items()
        if camera is robot.camera or name in spec.cameras
    }


def depth_topics(robot: RobotFile, spec: RosSpec) -> dict[str, tuple[DepthCameraSpec, RosDepthSpec]]:
    """Return the description and the topics of each depth camera that has topics, by name in the file."""
    found = robot.all_of(DepthCameraSpec)
    return {name: (found[name], topics) for name, topics in spec.depth.items() if name in found}


def info_topics(robot: RobotFile, spec: RosSpec) -> list[str]:
    """Return the topics of the calibrations of all cameras that have topics."""
    first = [topic.info_topic for _, topic in camera_topics(robot, spec).values()]
    return first + [topics.info_topic for _, topics in depth_topics(robot, spec).values()]
