"""Drafts of a robot's file from what is on the air."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.description.ros_spec import RosArmSpec, RosGripperSpec, RosLidarSpec, RosSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.ros2.air_check.air_description import (
    COMMAND_KINDS,
    READING_KINDS,
    AirDescription,
    describe_air,
)
from handcart.backends.ros2.air_check.connected import connected
from handcart.backends.ros2.bench.local_air import LocalAir, LocalLink
from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.evaluation.robot_report.drafting.ros_draft import with_air
from handcart.evaluation.robot_report.drafting.ros_section import chosen, is_upside_down, ros_section
from handcart.evaluation.robot_report.outline import Outline, outline_of
from handcart.evaluation.trials.rig import LIBRARY_FOLDER

WORLD = LIBRARY_FOLDER / "world.yaml"
LIDAR = "range_sensor: {beams: 360, reach_m: 8, sigma_mm: 20}\n"
TIAGO = {
    "geometry_msgs/TwistStamped": ("/mobile_base_controller/cmd_vel",),
    "geometry_msgs/Twist": ("/joy_vel", "/nav_vel", "/key_vel", "/cmd_vel_nav"),
    "nav_msgs/Odometry": ("/ground_truth_odom", "/mobile_base_controller/odom"),
    "sensor_msgs/JointState": ("/joint_states",),
    "sensor_msgs/LaserScan": ("/scan_raw", "/scan_filtered"),
    "sensor_msgs/Image": (
        "/head_front_camera/depth_registered/image_raw",
        "/head_front_camera/rgb/image_raw",
        "/head_front_camera/rgb/image_rect_color",
    ),
    "trajectory_msgs/JointTrajectory": (
        "/arm_controller/joint_trajectory",
        "/gripper_controller/joint_trajectory",
        "/head_controller/joint_trajectory",
        "/torso_controller/joint_trajectory",
    ),
}
"""Topics of a TIAGo, as its users list them."""
ARM = ("torso_lift_joint", "head_1_joint", "head_2_joint", *(f"arm_{n}_joint" for n in range(1, 8)))


def air(topics: Mapping[str, tuple[str, ...]], **more: Any) -> AirDescription:
    """Return a robot on the air with these topics."""
    every = {**dict.fromkeys((*READING_KINDS, *COMMAND_KINDS), ()), **topics}
    given = {"urdf": "", "srdf": "", "messages": {}, "controllers": {}} | more
    return AirDescription(topics=every, **given)


def outline(arm: tuple[str, ...] = ARM) -> Outline:
    fingers = ("gripper_left_finger_joint", "gripper_right_finger_joint")
    return Outline("base_footprint", 0.0, None, arm, "hand", fingers, (), {}, (arm,))


def test_topics_of_a_tiago_become_its_section() -> None:
    text = "\n".join(ros_section(air(TIAGO), outline()))
    for line in (
        "velocity: {topic: mobile_base_controller/cmd_vel, type: TwistStamped}",
        "odometry: {topic: mobile_base_controller/odom}",
        "lidar: {topic: scan_raw}",
        "camera: {topic: head_front_camera/rgb/image_raw}",
        "torso_controller/joint_trajectory: [torso_lift_joint]",
        "head_controller/joint_trajectory: [head_1_joint, head_2_joint]",
        f"arm_controller/joint_trajectory: [{', '.join(ARM[3:])}]",
        "joints: [gripper_left_finger_joint, gripper_right_finger_joint]",
    ):
        assert line in text


def test_a_controller_that_tells_its_joints_is_believed() -> None:
    joints_by_topic = {"/left/joint_trajectory": ARM[1:], "/lift/joint_trajectory": ARM[:1]}
    topics = {"trajectory_msgs/JointTrajectory": tuple(joints_by_topic)}
    lines = ros_section(air(topics, controllers=joints_by_topic), outline())
    assert f"      left/joint_trajectory: [{', '.join(ARM[1:])}]" in lines
    assert "      lift/joint_trajectory: [torso_lift_joint]" in lines


def test_controllers_without_a_topic_are_drafted_by_their_actions() -> None:
    topics = {"trajectory_msgs/JointTrajectory": ("/torso_controller/joint_trajectory",)}
    actions = {
        "control_msgs/FollowJointTrajectory": tuple(
            f"/{name}_controller/follow_joint_trajectory" for name in ("arm", "head", "torso")
        ),
        "control_msgs/GripperCommand": ("/gripper_controller/gripper_cmd",),
    }
    lines = ros_section(air(topics, actions=actions), outline())
    begin = lines.index("  arm:")
    by_name = "     # by its name; look at its parameter `joints`"
    assert lines[begin:] == [
        "  arm:",
        "    controllers:",
        f"      torso_controller/joint_trajectory: [torso_lift_joint]{by_name}",
        "    actions:",
        f"      arm_controller/follow_joint_trajectory: [{', '.join(ARM[3:])}]{by_name}",
        f"      head_controller/follow_joint_trajectory: [head_1_joint, head_2_joint]{by_name}",
        "  gripper: {action: gripper_controller/gripper_cmd,"
        " joints: [gripper_left_finger_joint, gripper_right_finger_joint]}",
    ]


def test_a_gripper_by_a_trajectory_action_names_its_type() -> None:
    actions = {"control_msgs/FollowJointTrajectory": ("/hand_controller/follow_joint_trajectory",)}
    (line,) = [text for text in ros_section(air({}, actions=actions), outline()) if "gripper:" in text]
    assert "{action: hand_controller/follow_joint_trajectory, action_type: FollowJointTrajectory," in line


def test_actions_on_the_air_are_described() -> None:
    robot = load_robot("librarian")
    assert robot.arm is not None and robot.camera is not None
    robot = robot.with_sensors({robot.name_of(robot.camera): None}).read_in(robot.folder)
    joints = outline_of(robot.urdf_text()).arm
    arm = RosArmSpec(actions={"arm/follow_joint_trajectory": joints})
    spec = RosSpec(arm=arm, gripper=RosGripperSpec(action="hand/gripper_cmd"))
    with connected(robot, spec, make_backend("kinematic", robot, WORLD, 0)) as (link, wait):
        described = describe_air(link, wait, 0.2)
    assert described.actions == {
        "control_msgs/FollowJointTrajectory": ("arm/follow_joint_trajectory",),
        "control_msgs/GripperCommand": ("hand/gripper_cmd",),
    }


def test_late_discovery_is_awaited_within_bounds() -> None:
    air, kind = LocalAir(), "control_msgs/FollowJointTrajectory"
    drivers, link = LocalLink(air, "drivers"), LocalLink(air, "draft")
    drivers.latched("std_msgs/String", "robot_description")(SimpleNamespace(data="<robot/>"))
    names = iter(f"controller_{number}" for number in range(100))

    def wait() -> None:
        air.time += 0.1
        if air.time > 2.5 and air.time % 0.9 < 0.1:  # after 1.5 s, one by one, without an end
            drivers.serve_action(kind, next(names), lambda goal: True, lambda goal: None)

    described = describe_air(link, wait, 2.0)
    assert len(described.actions[kind]) > 3
    assert 7.0 < air.time - 1.0 < 8.5


def test_joints_without_a_controller_are_told() -> None:
    topics = {
        "trajectory_msgs/JointTrajectory": (
            "/arm_controller/joint_trajectory",
            "/x_controller/joint_trajectory",
        )
    }
    assert any(
        "no controller was found for torso_lift_joint" in line for line in ros_section(air(topics), outline())
    )


def test_topics_are_relative_to_the_namespace() -> None:
    topics = {"nav_msgs/Odometry": ("/r1/odom",), "sensor_msgs/LaserScan": ("/shared/scan",)}
    lines = ros_section(air(topics, namespace="/r1"), outline(()))
    assert "  namespace: /r1" in lines
    assert "  odometry: {topic: odom}" in lines
    assert "  lidar: {topic: /shared/scan}" in lines


@pytest.mark.parametrize(
    ("key", "topics", "best"),
    [
        ("velocity", ("/cmd_vel_nav", "/cmd_vel", "/cmd_vel_joy"), "/cmd_vel"),
        ("odometry", ("/odometry/filtered", "/diff_drive_controller/odom"), "/diff_drive_controller/odom"),
        ("camera", ("/camera/depth/image_raw", "/camera/color/image_raw"), "/camera/color/image_raw"),
        ("imu", ("/imu/data_raw", "/imu/data", "/imu/mag"), "/imu/data"),
        ("lidar", (), ""),
    ],
)
def test_the_topic_that_fits_best_is_chosen(key: str, topics: tuple[str, ...], best: str) -> None:
    assert chosen(key, topics)[0] == best


def test_sensors_and_postures_are_as_measured() -> None:
    robot = load_robot("librarian")
    urdf = robot.urdf_text()
    found = outline_of(urdf)
    values = "".join(f'<joint name="{name}" value="0.5"/>' for name in found.arm)
    srdf = f'<robot name="r"><group_state name="carry pose" group="arm">{values}</group_state></robot>'
    scan = SimpleNamespace(
        angle_min=-1.6581, angle_increment=0.0122829, ranges=[1.0] * 271, range_min=0.05, range_max=25.0
    )
    scan.header = SimpleNamespace(frame_id="laser")
    topics = {"sensor_msgs/LaserScan": ("/scan",)}
    heard = air(topics, urdf=urdf, srdf=srdf, messages={"/scan": scan})
    draft = 'urdf: "r.urdf"\n    home: [0]\nrange_sensor: {beams: 360, reach_m: 8, sigma_mm: 20}\n'
    text = with_air(draft, heard, found, "r.srdf")
    assert 'urdf: "r.urdf"\nsrdf: "r.srdf"\n' in text
    assert "beams: 271, start_deg: -95.002, end_deg: 95.013, range_min_m: 0.05, reach_m: 25" in text
    assert "    carry_pose: [28.65, 28.65, 28.65, 28.65, 28.65, 28.65]     # of the SRDF" in text


def described_upside_down(is_upside_down: bool) -> tuple[AirDescription, str]:
    """Return what is heard of the librarian, its lidar mounted one way or the other, and its draft."""
    robot = load_robot("librarian")
    assert robot.camera is not None
    robot = robot.with_sensors({robot.name_of(robot.camera): None}).read_in(robot.folder)
    spec = RosSpec(lidar=RosLidarSpec(upside_down=is_upside_down))
    with connected(robot, spec, make_backend("kinematic", robot, WORLD, 0)) as (link, wait):
        described = describe_air(link, wait, 0.3)
    return described, with_air(LIDAR, described, outline_of(described.urdf), "")


@pytest.mark.parametrize("is_upside_down", [False, True])
def test_a_lidar_that_hangs_upside_down_is_drafted_so(is_upside_down: bool) -> None:
    described, text = described_upside_down(is_upside_down)
    line = "  lidar: {topic: scan, upside_down: true}" if is_upside_down else "  lidar: {topic: scan}"
    assert line in text.splitlines()
    scan = described.messages["scan"]
    scan.angle_min, scan.ranges = math.radians(-30.0), scan.ranges[:91]  # from -30 to 60 deg, as it counts
    text = with_air(LIDAR, described, outline_of(described.urdf), "")
    ends = "start_deg: -60, end_deg: 30" if is_upside_down else "start_deg: -30, end_deg: 60"
    assert ends in text


def test_a_lidar_without_a_frame_is_marked_in_the_draft() -> None:
    described, _ = described_upside_down(True)
    described.messages["scan"].header.frame_id = "laser"
    lines = ros_section(described._replace(frames=FrameTree()), outline_of(described.urdf))
    place = lines.index("  lidar: {topic: scan}")
    assert "tf lacks the lidar's frame 'laser'" in lines[place - 1]


def test_a_lidar_upside_down_by_the_urdf_alone_is_drafted_so() -> None:
    turned = '<parent link="b"/><child link="laser"/><origin rpy="3.1416 0 0"/>'
    joint = f'<joint name="j" type="fixed">{turned}</joint>'
    urdf = f'<robot name="r"><link name="b"/><link name="laser"/>{joint}</robot>'
    assert is_upside_down(air({}, urdf=urdf), "laser", "b") is True
    assert is_upside_down(air({}, urdf=urdf.replace("3.1416", "0")), "laser", "b") is False
    assert is_upside_down(air({}, urdf=urdf), "camera", "b") is None
