"""Reading of trees of py_trees that are in memory, as tasks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .lost import Imported, LostConstruct
from .task_draft import TaskDraft
from .tree_flow import TreeFlow
from .tree_node import BehaviourNode

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

MAX_NODES = 5_000
DECORATOR_TAGS = {
    "Inverter": "Inverter",
    "Retry": "RetryUntilSuccessful",
    "Repeat": "Repeat",
    "Timeout": "Timeout",
    "FailureIsSuccess": "ForceSuccess",
    "SuccessIsFailure": "ForceFailure",
    "OneShot": "RunOnce",
    "PassThrough": "Sequence",
}
"""Decorators of py_trees by the names of BehaviorTree.CPP; others are lost."""
CONSTANT_LEAVES = {"Success": "AlwaysSuccess", "Failure": "AlwaysFailure"}


def import_py_tree(root: Behaviour) -> Imported:
    """Convert a behaviour tree of py_trees to a task; the class of each leaf gives the primitive's name."""
    lost: dict[LostConstruct, None] = {}
    tree = _node(root, lost, [0])
    draft = TaskDraft(root.name)
    flow = TreeFlow(draft, {root.name: tree})
    start = flow.translate(root.name)
    return Imported(draft.data(start, backwards=True), tuple(sorted({**lost, **flow.lost})))


def _node(behaviour: Behaviour, lost: dict[LostConstruct, None], count: list[int]) -> BehaviourNode:
    from py_trees import composites, decorators

    count[0] += 1
    if count[0] > MAX_NODES:
        raise ValueError(f"the tree has more than {MAX_NODES} nodes; allowed: fewer")
    children = tuple(_node(child, lost, count) for child in behaviour.children)
    kind = type(behaviour).__name__
    shown = f"{kind} {behaviour.name!r}"
    for composite, plain in ((composites.Sequence, "Sequence"), (composites.Selector, "Fallback")):
        if isinstance(behaviour, composite):
            control = plain if behaviour.memory else f"Reactive{plain}"
            return BehaviourNode(control, "", {}, children, shown=shown)
    if isinstance(behaviour, composites.Parallel):
        return BehaviourNode("Parallel", "", {}, children, shown=shown)
    if isinstance(behaviour, decorators.Decorator):
        ports = {key: str(value) for key, value in _numbers(behaviour).items()}
        return BehaviourNode(DECORATOR_TAGS.get(kind, kind), "", ports, children, shown=shown)
    return BehaviourNode(CONSTANT_LEAVES.get(kind, kind), behaviour.name, {}, children, shown=shown)


def _numbers(behaviour: Any) -> dict[str, Any]:
    """Return the numbers of a decorator, by the ports of BehaviorTree.CPP."""
    names = {"num_failures": "num_attempts", "num_success": "num_cycles", "duration": "seconds"}
    return {port: getattr(behaviour, name) for name, port in names.items() if hasattr(behaviour, name)}
