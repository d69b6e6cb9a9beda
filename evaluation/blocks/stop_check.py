"""Reach of the arm from each stop of a stacking task, computed without moving."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.backends.loading.robot_loading import load_robot
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task
from handcart.primitives.blocks.blocks import Blocks
from handcart.primitives.blocks.building import Building
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.blocks.stack import Stack
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.manipulation.placement.stops import STOP_OFFSET_M
from handcart.robotics.numerics.arrays import FloatArray

from .stop_reach import StopReach

Work = dict[tuple[str, str], dict[str, LevelPose]]
"""Poses of the blocks taken or laid from each stop of the base, by the stop's place and landmark, then by
block.
"""


def block_facts(task: Task) -> dict[str, Any]:
    """Describe which blocks the arm reaches from each stop of the base in a stacking task.

    At a stop, the base is located by a landmark.

    Returns:
        A text for each stop, with keys such as `stop NAME`; empty for a task that handles no blocks. If the
            robot cannot handle blocks at all, only the key `stops` with the reason.
    """
    blocks = task.knowledge.sections.get("blocks")
    plan = blocks.building if isinstance(blocks, Blocks) else None
    work = {} if plan is None else _work(task, plan)
    if plan is None or not work:
        return {}
    try:
        reach = StopReach(load_robot(task.robot), plan.block)
    except Discrepancy as lacking:
        return {"stops": f"not known: {lacking.reason}"}
    places = task.knowledge.all_places()
    return {
        f"stop {name}": _words(reach, plan, np.array(places[name].pose), mark, todo)
        for (name, mark), todo in work.items()
        if name in places
    }


def _words(reach: StopReach, plan: Building, base: FloatArray, mark: str, todo: dict[str, LevelPose]) -> str:
    placer = reach.stops([plan.landmarks[mark]])
    names, goals = list(todo), [reach.goal(place) for place in todo.values()]
    table = placer.table(base[None], goals)
    if not table.sights[0, 0]:
        return f"landmark {mark} can't be looked at from {1e3 * STOP_OFFSET_M:g} mm beside it"
    values, served = table.values[0], table.served[0]
    missed = [name for name, good in zip(names, served.tolist(), strict=True) if not good]
    if missed:
        return f"not reached from {1e3 * STOP_OFFSET_M:g} mm beside it: {', '.join(missed)}"
    least = int(np.argmin(values))
    return (
        f"reaches {len(names)} blocks, score {values.mean():.2f}, least {values[least]:.2f} at {names[least]}"
    )


def _work(task: Task, plan: Building) -> Work:
    """Return the work at each stop by the network: from each FIXATE until the base drives, or the next
    FIXATE.
    """
    found: Work = {}
    for action in task.network.actions:
        if not _does(action, Fixate) or action.binding is None:
            continue
        fixed = action.binding.fixed
        name = fixed.get("landmark")
        if name not in plan.landmarks:
            continue
        place = fixed.get("place") or plan.landmarks[name].place
        todo = found.setdefault((place, name), {})
        for action_ in _until_driven(task, action.target):
            todo |= _block(action_, plan)
    return {key: todo for key, todo in found.items() if todo}


def _until_driven(task: Task, situation: str) -> list[Action]:
    """Return the actions that may follow a situation, up to a MOVE_TO or a FIXATE."""
    seen, ahead, found = {situation}, [situation], list[Action]()
    while ahead:
        for _, target, action in task.network.graph.out_edges(ahead.pop(), data="action"):
            if _does(action, MoveTo) or _does(action, Fixate):
                continue
            found.append(action)
            if target not in seen:
                seen.add(target)
                ahead.append(target)
    return found


def _block(action: Action, plan: Building) -> dict[str, LevelPose]:
    """Return the block that an action takes from the supply, or lays."""
    fixed = action.binding.fixed if action.binding else {}
    number = fixed.get("number", 0)
    if _does(action, PickUpBlock) and fixed.get("at") == "supply" and 0 < number <= len(plan.supply):
        return {f"block {number}": plan.supply[number - 1]}
    if _does(action, Stack) and fixed.get("onto") == "goal" and 0 < number <= len(plan.goals):
        return {f"goal {number}": plan.goals[number - 1]}
    return {}


def _does(action: Action, kind: type) -> bool:
    return action.binding is not None and issubclass(action.binding.kind, kind)
