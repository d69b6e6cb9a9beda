"""Steps that bring a robot up by ROS 2, in order."""

from __future__ import annotations

from typing import Any

from handcart.evaluation.bringup.rung import Rung
from handcart.evaluation.bringup.use_rungs import CameraRung, PrimitiveRung, RangesRung, TaskRung

from .base_rung import BaseRung
from .gripper_rung import GripperRung
from .joints_rung import JointsRung
from .silence_rung import SilenceRung
from .topics_rung import TopicsRung

ROS_RUNGS: tuple[Rung[Any], ...] = (
    TopicsRung(),
    SilenceRung(),
    BaseRung(),
    JointsRung(),
    GripperRung(),
    RangesRung(),
    CameraRung(),
    PrimitiveRung(),
    TaskRung(),
)
"""Steps in order; the base's stop on silence is tested first, the joints' signs before the arm works."""
