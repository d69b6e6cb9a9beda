"""Drive the cart of a bench and read its topics with rclpy alone, by another distribution's Python.

`python benchmarks/ros2/other_side.py SECONDS` needs neither handcart nor its packages, prints one JSON object
and ends. `benchmarks.ros2.counterparts` runs it.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from importlib import import_module
from importlib.metadata import version
from typing import Any

SPEED_M_S = 0.2


def main() -> None:
    """Drive straight on and move a joint, and print what was read."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("seconds", type=float, help="for which it drives")
    asked = words.parse_args()
    rclpy, sensors = import_module("rclpy"), import_module("sensor_msgs.msg")
    best_effort = import_module("rclpy.qos").qos_profile_sensor_data
    odometry, twist = import_module("nav_msgs.msg").Odometry, import_module("geometry_msgs.msg").Twist
    trajectory = import_module("trajectory_msgs.msg").JointTrajectory
    rclpy.init()
    node = rclpy.create_node("other_side")
    way: list[float] = []
    scans: list[int] = []
    joints: list[Any] = []
    node.create_subscription(
        odometry, "odom", lambda message: way.append(message.pose.pose.position.x), best_effort
    )
    node.create_subscription(
        sensors.LaserScan, "scan", lambda message: scans.append(len(message.ranges)), best_effort
    )
    node.create_subscription(sensors.JointState, "joint_states", joints.append, best_effort)
    speeds = node.create_publisher(twist, "cmd_vel", 1)
    points = node.create_publisher(trajectory, "arm_controller/joint_trajectory", 1)
    end = time.monotonic() + asked.seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.02)
        if not way:
            continue
        message = twist()
        message.linear.x = SPEED_M_S
        speeds.publish(message)
        if joints:
            points.publish(moved(joints[0]))
    print(
        json.dumps(
            {
                "rclpy": f"{version('rclpy')} {os.environ.get('ROS_DISTRO', '')}".strip(),
                "python": sys.version.split()[0],
                "odometry": len(way),
                "driven_m": way[-1] - way[0] if way else 0.0,
                "scans": len(scans),
                "beams": scans[-1] if scans else 0,
                "joint_states": len(joints),
                "joint_moved": turned(joints),
            }
        )
    )


def moved(first: Any) -> Any:
    """Return a command that moves the first joint by 0.1 from where it was at first."""
    arm = [name for name in first.name if name.startswith("joint_")]
    messages = import_module("trajectory_msgs.msg")
    point = messages.JointTrajectoryPoint()
    point.positions = [first.position[first.name.index(name)] for name in arm]
    point.positions[0] += 0.1
    point.time_from_start.nanosec = 500_000_000
    message = messages.JointTrajectory()
    message.joint_names, message.points = arm, [point]
    return message


def turned(joints: list[Any]) -> float:
    """Return by how much the first joint of the arm moved."""
    if not joints:
        return 0.0
    place = next((i for i, name in enumerate(joints[0].name) if name.startswith("joint_")), None)
    return 0.0 if place is None else float(joints[-1].position[place] - joints[0].position[place])


if __name__ == "__main__":
    main()
