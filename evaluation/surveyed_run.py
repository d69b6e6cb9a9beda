"""What a survey may look at: a robot, what it knows, and the simulated world as it truly is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handcart.backends.robot import Robot
from handcart.backends.robot_file import RobotFile
from handcart.networks.preparing import Prepared
from handcart.primitives.world_model import WorldModel

from .ground_truth import scene_of


@dataclass(frozen=True)
class SurveyedRun:
    """A run that is surveyed, or a single attempt."""

    robot: Robot
    spec: RobotFile
    """The robot's file as it is at first: a calibration changes the robot's own."""
    model: WorldModel
    world: Any
    """Ground truth; None where nothing is simulated."""
    seed: int = 0
    """Of the simulated errors."""
    does: frozenset[str] = frozenset()
    """Names of the primitives that it may come to."""
    folder: Path | None = None
    """Where a survey may keep notes; None: nowhere."""

    @classmethod
    def of(cls, prepared: Prepared, folder: Path | None = None) -> SurveyedRun:
        """A run of a task that hasn't started."""
        robot = prepared.robot
        does = frozenset(action.do for action in prepared.task.network.actions)
        world = scene_of(prepared.backend)
        return cls(robot, robot.spec, prepared.model, world, prepared.seed, does, folder)
