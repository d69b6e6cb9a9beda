"""The kinds of files that users write."""

from __future__ import annotations

from importlib import import_module
from typing import Any

KINDS = {
    "task": "networks.task_model:TaskFile",
    "robot": "backends.robot_file:RobotFile",
    "world": "backends.scene.world_file:WorldFile",
    "table": "networks.analysis.action_table:ActionTable",
    "places": "primitives.knowledge:Places",
    "catalogue": "primitives.knowledge:Catalogue",
    "work-piece": "primitives.work_piece:WorkPiece",
    "building": "primitives.building:Building",
    "calibration": "networks.calibration:Calibration",
}
"""What stands behind `handcart-` under the key `format`, and the model that reads it."""


def model_of(kind: str) -> Any:
    """The class of a kind of file; raises KeyError for an unknown one."""
    module, _, name = KINDS[kind].partition(":")
    return getattr(import_module(module), name)
