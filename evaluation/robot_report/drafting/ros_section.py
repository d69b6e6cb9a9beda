"""Draft of the section `ros2` from the topics that are on the air."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from handcart.backends.ros2.air_check.air_description import (
    VELOCITY_KINDS,
    AirDescription,
    controller_of,
)
from handcart.backends.ros2.wire.frame_tree import plain
from handcart.backends.ros2.wire.messages import GRIPPER_ACTION, TRAJECTORY_ACTION
from handcart.evaluation.robot_report.outline import Outline
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.kinematics.urdf_frames import link_poses

TOPIC_WORDS: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "velocity": (("cmd_vel",), ("nav", "joy", "teleop", "key", "smooth", "raw", "unstamped", "phone", "tab")),
    "odometry": (("odom", "controller"), ("filtered", "global", "truth", "amcl", "visual", "vio", "gps")),
    "joint_states": (("joint_states",), ("dynamic", "command", "desired")),
    "lidar": (("scan",), ("filtered", "multi", "3d", "cloud")),
    "camera": (("rgb", "color", "image_raw"), ("depth", "infra", "mask", "debug", "rect", "compressed")),
    "imu": (("imu", "data"), ("mag", "temp", "raw")),
    "gripper": (("gripper", "hand", "finger"), ()),
}
"""Words in a topic's name that speak for and against it."""
MESSAGE_KINDS = {
    "odometry": "nav_msgs/Odometry",
    "joint_states": "sensor_msgs/JointState",
    "lidar": "sensor_msgs/LaserScan",
    "camera": "sensor_msgs/Image",
    "imu": "sensor_msgs/Imu",
}
CONTROLLER_KINDS = ("trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray")


def chosen(key: str, topics: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Return the topic whose name contains the most words typical of a key in the section `ros2`, and the
    other topics.

    Words typical of other topics count against a name. Without topics, return "" and an empty tuple.
    """
    if not topics:
        return "", ()
    good, bad = TOPIC_WORDS[key]

    def rank(topic: str) -> tuple[int, int, str]:
        score = sum(word in topic for word in good) - 2 * sum(word in topic for word in bad)
        return -score, len(topic), topic

    first, *others = sorted(topics, key=rank)
    return first, tuple(others)


def ros_section(air: AirDescription, outline: Outline) -> list[str]:
    """Return the lines of the section `ros2` of a robot's file, with the topics whose message types and names
    fit its keys best.

    Other candidate topics are listed in comments.
    """
    lines = [
        "ros2:     # by the topics on the air; next: handcart check --ros2, then handcart bringup --ros2"
    ]
    lines += [f"  namespace: {air.namespace}"] if air.namespace else []
    lines += _velocity(air)
    for key, kind in MESSAGE_KINDS.items():
        name, others = chosen(key, air.topics[kind])
        if name:
            more = _frame(air, name) if key == "odometry" else ""
            more += _mount(air, name, outline) if key == "lidar" else ""
            lines += _unknown_mount(air, name, outline) if key == "lidar" else []
            lines.append(f"  {key}: {{topic: {_plain(air, name)}{more}}}{_or(air, others)}")
    lines += _controllers(air, outline)
    return lines


def is_upside_down(air: AirDescription, frame: str, root: str) -> bool | None:
    """Return whether the z axis of a lidar's frame points down; None if neither `tf` nor the URDF shows it.

    Args:
        air: description that the robot publishes of itself.
        frame: frame of the scans.
        root: link of the URDF on which the robot stands.
    """
    odometry = air.messages.get(chosen("odometry", air.topics[MESSAGE_KINDS["odometry"]])[0])
    for base in (getattr(odometry, "child_frame_id", ""), root):
        pose = air.frames.pose(base, frame) if base else None
        if pose is not None:
            return bool(pose[2, 2] < 0.0)
    poses = link_poses(air.urdf) if air.urdf else {}
    if not {frame, root} <= poses.keys():
        return None
    return bool((inverse(poses[root]) @ poses[frame])[2, 2] < 0.0)


def _mount(air: AirDescription, topic: str, outline: Outline) -> str:
    scan = air.messages.get(topic)
    is_down = scan is not None and is_upside_down(air, plain(scan.header.frame_id), outline.root)
    return ", upside_down: true" if is_down else ""


def _unknown_mount(air: AirDescription, topic: str, outline: Outline) -> list[str]:
    scan = air.messages.get(topic)
    if scan is None or is_upside_down(air, plain(scan.header.frame_id), outline.root) is not None:
        return []
    frame = scan.header.frame_id
    return [f"  # tf lacks the lidar's frame {frame!r}; `upside_down: true` below if its scans run clockwise"]


def _velocity(air: AirDescription) -> Iterator[str]:
    found = {topic: kind for kind in reversed(VELOCITY_KINDS) for topic in air.topics[kind]}
    name, others = chosen("velocity", list(found))
    if name:
        kind = found[name].partition("/")[2]
        yield f"  velocity: {{topic: {_plain(air, name)}, type: {kind}}}{_or(air, others)}"


def _controllers(air: AirDescription, outline: Outline) -> Iterator[str]:
    """Yield the arm's and the gripper's controllers: by topics, or by actions where they have no topic."""
    kind = next((controller_kind for controller_kind in CONTROLLER_KINDS if air.topics[controller_kind]), "")
    topics = list(air.topics[kind]) if kind else []
    with_topic = set(map(controller_of, topics))
    actions = [
        item for item in air.actions.get(TRAJECTORY_ACTION, ()) if controller_of(item) not in with_topic
    ]
    if not outline.arm:
        return
    fingers = set(outline.fingers or ()) | set(outline.turning_fingers)
    every = [*topics, *actions]
    grippers = [item for item in every if _moves(air, item, fingers) or _is_gripper(air, item)]
    joints = _joints_by_topic(air, [item for item in every if item not in grippers], outline.arm)
    yield from _arm(air, kind, joints, topics)
    left = [name for name in outline.arm if not any(name in names for names in joints.values())]
    if left and (every or air.actions.get(GRIPPER_ACTION)):
        yield f"  # no controller was found for {', '.join(left)}"
    if outline.fingers:
        yield from _gripper(air, grippers, actions, outline.fingers)


def _arm(
    air: AirDescription, kind: str, joints: Mapping[str, Sequence[str]], topics: Sequence[str]
) -> Iterator[str]:
    """Yield the section `arm`; `joints` by topic or action, `topics` of the type `kind`."""
    if not joints:
        return
    yield "  arm:"
    by_topic = {name: names for name, names in joints.items() if name in topics}
    by_action = {name: names for name, names in joints.items() if name not in topics}
    if by_topic and not kind.endswith("Trajectory"):
        yield f"    type: {kind.partition('/')[2]}"
    for key, found in (("controllers", by_topic), ("actions", by_action)):
        if found:
            yield f"    {key}:"
        for name, names in found.items():
            sure = "" if name in air.controllers else "     # by its name; look at its parameter `joints`"
            yield f"      {_plain(air, name)}: [{', '.join(names)}]{sure}"


def _gripper(
    air: AirDescription, grippers: Sequence[str], actions: Sequence[str], fingers: Sequence[str]
) -> Iterator[str]:
    """Yield the section `gripper`: a topic before an action, which costs more."""
    commands = list(air.actions.get(GRIPPER_ACTION, ()))
    by_topic = [gripper for gripper in grippers if gripper not in actions]
    name, others = chosen("gripper", by_topic or commands or grippers)
    if not name:
        return
    joints = ", ".join(air.controllers.get(name) or fingers)
    key = "topic" if by_topic else "action"
    kind = ", action_type: FollowJointTrajectory" if key == "action" and name not in commands else ""
    yield f"  gripper: {{{key}: {_plain(air, name)}{kind}, joints: [{joints}]}}{_or(air, others)}"


def _joints_by_topic(
    air: AirDescription, topics: Sequence[str], arm: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return the arm's joints of each controller's topic or action: as its node says, or by its name."""
    known = {topic: tuple(name for name in air.controllers.get(topic, ()) if name in arm) for topic in topics}
    found = {topic: names for topic, names in known.items() if names}
    left = [name for name in arm if not any(name in names for names in found.values())]
    unsure = [topic for topic in topics if topic not in air.controllers]
    if len(unsure) == 1 and left:
        return {**found, unsure[0]: tuple(left)}
    for topic in unsure:
        word = topic.strip("/").split("/")[-2].partition("_")[0] if "/" in topic.strip("/") else topic
        names = tuple(name for name in left if name.startswith(word))
        if names:
            found[topic] = names
    return found


def _moves(air: AirDescription, topic: str, fingers: set[str]) -> bool:
    return bool(fingers & set(air.controllers.get(topic, ())))


def _is_gripper(air: AirDescription, topic: str) -> bool:
    return topic not in air.controllers and any(word in topic for word in TOPIC_WORDS["gripper"][0])


def _frame(air: AirDescription, topic: str) -> str:
    message = air.messages.get(topic)
    return "" if message is None else f", frame: {message.header.frame_id}"


def _plain(air: AirDescription, topic: str) -> str:
    """Return a topic relative to the robot's namespace; one outside of it as it is."""
    return topic.removeprefix(f"{air.namespace}/")


def _or(air: AirDescription, others: Sequence[str]) -> str:
    return f"     # or {', '.join(_plain(air, other) for other in others)}" if others else ""
