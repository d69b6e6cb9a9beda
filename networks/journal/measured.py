"""The measured state of a robot at rest, as fields of the journal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.restoring.snapshot import Snapshot, take_snapshot
from handcart.robotics.geometry.pose2 import Pose2

from .run_records import At


def measure(robot: Robot) -> Snapshot | None:
    """Return a snapshot of the robot without observed objects; None if reading the robot's state fails."""
    try:
        return take_snapshot(robot, {})
    except Exception:  # a sensor that is broken at the end of a run must not hide how the run ended
        return None


def measured_fields(at: Snapshot) -> At:
    """Return a snapshot ready for JSON: lengths in [m], angles in [rad]; unknown values are null."""
    fields = At(base=list(at.pose), base_sigma=list(at.pose_sigma))
    if at.joints.size:
        fields["joints"] = at.joints.tolist()
        fields["joint_command"] = at.joint_command.tolist()
    if at.gripper_width or at.gripper_command:
        fields["grip"] = at.gripper_width
        fields["grip_command"] = at.gripper_command
        fields["holding"] = at.holding
    return fields


def snapshot_of(fields: Mapping[str, Any]) -> Snapshot:
    """Return the robot's snapshot from the fields with which the journal stores it (`measured_fields`).

    Raises:
        KeyError, TypeError: the fields do not describe a snapshot.
    """
    far, turned = (math.inf if item is None else float(item) for item in fields["base_sigma"])
    return Snapshot(
        Pose2(*fields["base"]),
        (far, turned),
        np.array(fields.get("joints", ()), dtype=np.float64),
        np.array(fields.get("joint_command", ()), dtype=np.float64),
        float(fields.get("grip_command", 0.0)),
        float(fields.get("grip", 0.0)),
        bool(fields.get("holding", False)),
        {},
    )
