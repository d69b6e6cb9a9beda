"""Check without moving whether a task's seam can be tracked."""

from __future__ import annotations

from typing import Any

from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from handcart.networks.task.preparing import load_model
from handcart.networks.task.task_file import Task
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.seam.divide import Divide
from handcart.primitives.seam.seam import Seam
from handcart.primitives.seam.seam_file import untrackable
from handcart.primitives.seam.seam_placer import placer_of
from handcart.robotics.manipulation.paths.untrackable import Untrackable


def seam_facts(task: Task) -> dict[str, Any]:
    """Return how the primitive DIVIDE would divide a task's seam among poses of the base.

    The result is empty for a task without DIVIDE.

    Raises:
        FileError: a point of the seam cannot be tracked (the first one, with reason and nearest reachable
            point), or the robot lacks a suitable tool or arm.
    """
    divides, file = _divides(task), task.path("knowledge", "seam")
    if not divides or file is None:
        return {}
    most = max(divides, key=lambda divide: divide.placements)
    spec, (model, _) = load_robot(task.robot), load_model(task)
    work = model.of(Seam)
    assert work.seam is not None, "its file is named"
    boxes = tuple(box.box for box in work.work_piece.boxes) if work.work_piece else ()
    try:
        placer, start = placer_of(spec), task.knowledge.start
        room = StandingRoom(spec, placer.arm, model.map, model.obstacles, start, boxes)
        found = most.divided(placer, work.seam, room)
    except Discrepancy as lacking:
        raise FileError([task.document.finding(("robot",), f"DIVIDE can't be done: {lacking}")]) from None
    except Untrackable as error:
        raise untrackable(str(file), error) from None
    length, count = work.seam.length, len(found.segments)
    what = "placements" if most.base == "stands" else "straight ways" if count > 1 else "straight way"
    return {"seam": f"{length:.2f} m, {count} {what}, score {found.score / length:.3f}"}


def _divides(task: Task) -> list[Divide]:
    """Return each DIVIDE action of the network whose parameters are all known."""
    bindings = [action.binding for action in task.network.actions if action.binding is not None]
    return [
        binding.kind.model_validate(binding.fixed)
        for binding in bindings
        if issubclass(binding.kind, Divide) and not binding.late
    ]
