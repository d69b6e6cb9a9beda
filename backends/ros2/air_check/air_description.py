"""A robot that describes itself on the air: its URDF, its SRDF, its topics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.backends.ros2.wire.messages import (
    GRIPPER_ACTION,
    SRDF_TOPIC,
    TRAJECTORY_ACTION,
    URDF_TOPIC,
)
from handcart.backends.ros2.wire.ros_errors import NoRos, NotOnTheAir
from handcart.backends.ros2.wire.ros_link import Link

VELOCITY_KINDS = ("geometry_msgs/TwistStamped", "geometry_msgs/Twist")
COMMAND_KINDS = (*VELOCITY_KINDS, "trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray")
ACTION_KINDS = (TRAJECTORY_ACTION, GRIPPER_ACTION)
READING_KINDS = (
    "nav_msgs/Odometry",
    "sensor_msgs/JointState",
    "sensor_msgs/LaserScan",
    "sensor_msgs/Image",
    "sensor_msgs/CameraInfo",
    "sensor_msgs/Imu",
    "sensor_msgs/NavSatFix",
    "geometry_msgs/WrenchStamped",
)
HEARD_KINDS = (
    "sensor_msgs/LaserScan",
    "sensor_msgs/CameraInfo",
    "nav_msgs/Odometry",
)
"""Types of messages of which one message is read."""
DISCOVERED_KINDS = (*READING_KINDS, *COMMAND_KINDS)
SETTLED_S = 1.0
"""Time without a new topic or action after which all nodes have been discovered, in [s]."""
MAX_DISCOVERY_S = 5.0
"""Longest wait for further topics and actions, beyond the time to listen, in [s]."""


class AirDescription(NamedTuple):
    """URDF, SRDF, topics, actions and controllers of a running robot, as found on its ROS topics."""

    urdf: str
    srdf: str
    """Text of the SRDF; "" without one."""
    topics: Mapping[str, tuple[str, ...]]
    """Topics of each type: published ones, or for a command those with a subscriber."""
    messages: Mapping[str, Any]
    """One message of each topic whose content is of use, by the topic's name."""
    controllers: Mapping[str, tuple[str, ...]]
    """Joints of each controller by its topic or action, where its node reports them."""
    namespace: str = ""
    """Namespace of the robot's topics."""
    actions: Mapping[str, tuple[str, ...]] = {}
    """Served actions of each type of `ACTION_KINDS`."""
    frames: FrameTree = FrameTree()
    """Frames by `tf` and `tf_static`; empty where their messages are not installed."""


def describe_air(link: Link, wait: Callable[[], None], seconds: float, namespace: str = "") -> AirDescription:
    """Collect what a robot's ROS nodes publish about the robot (see `AirDescription`), without sending
    anything.

    Args:
        link: connection to the robot's topics.
        wait: function that waits for a short time.
        seconds: time to listen, in [s]; it is extended while further topics and actions are being discovered.
        namespace: namespace of the robot's topics.

    Raises:
        NotOnTheAir: no node publishes `robot_description`.
    """
    texts: dict[str, str] = {}
    for topic in (URDF_TOPIC, SRDF_TOPIC):
        link.subscribe(
            "std_msgs/String", topic, _kept(texts, topic, lambda message: message.data), latched=True
        )
    frames = _heard_frames(link)
    messages: dict[str, Any] = {}
    heard: set[str] = set()
    begun = changed = link.clock()
    known: list[list[str]] = []
    while (now := link.clock()) - begun < seconds or now - changed < min(seconds, SETTLED_S):
        wait()
        found = [*map(link.topics_of, DISCOVERED_KINDS), *map(link.actions_of, ACTION_KINDS)]
        if found != known and now - begun < seconds + MAX_DISCOVERY_S:
            known, changed = found, now
        for kind in HEARD_KINDS:
            for topic in link.topics_of(kind):
                if topic not in heard:
                    heard.add(topic)
                    link.subscribe(kind, topic, _kept(messages, topic, lambda message: message))
        link.receive()
    if URDF_TOPIC not in texts:
        where = f" in {link.place}" if link.place else ""
        raise NotOnTheAir(
            [
                f"{URDF_TOPIC}: no URDF arrives within {seconds:g} s{where}; needed: robot_state_publisher,"
                " or `handcart check URDF --draft FILE` with the URDF as a file"
            ]
        )
    topics = {kind: tuple(_in_use(link, kind)) for kind in DISCOVERED_KINDS}
    actions = {kind: tuple(link.actions_of(kind)) for kind in ACTION_KINDS}
    commanded = [name for kind in COMMAND_KINDS[2:] for name in topics[kind]]
    commanded += [name for names in actions.values() for name in names]
    joints = {node: tuple(link.joints_of(node)) for node in dict.fromkeys(map(controller_of, commanded))}
    controllers = {name: joints[controller_of(name)] for name in commanded if joints[controller_of(name)]}
    texts.setdefault(SRDF_TOPIC, "")
    return AirDescription(
        texts[URDF_TOPIC], texts[SRDF_TOPIC], topics, messages, controllers, namespace, actions, frames
    )


def _heard_frames(link: Link) -> FrameTree:
    """Return the tree of the frames that the robot publishes from now on, or has published as static."""
    frames = FrameTree()
    with suppress(NoRos):
        link.subscribe("tf2_msgs/TFMessage", "tf_static", frames.take_static, latched=True)
        link.subscribe("tf2_msgs/TFMessage", "tf", frames.take)
    return frames


def controller_of(name: str) -> str:
    """Return the name of a controller's node, given its topic or action, such as `arm_controller` for
    `arm_controller/joint_trajectory`.
    """
    return name.rpartition("/")[0]


def _in_use(link: Link, kind: str) -> list[str]:
    """Return the topics of a type that are published or, for a command, have a subscriber."""
    look = link.listeners if kind in COMMAND_KINDS else link.publishers
    return [topic for topic in link.topics_of(kind) if any(f"({kind})" in item for item in look(topic))]


def _kept(into: dict[str, Any], topic: str, content: Callable[[Any], Any]) -> Callable[[Any], None]:
    def keep(message: Any) -> None:
        into[topic] = content(message)

    return keep
