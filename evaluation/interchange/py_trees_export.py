"""Tasks as trees of py_trees, in memory, and back.

The blackboard's key `situation` holds the situation. In each tick the tree does the first action that starts
in it and has attempts left; a leaf calls the function that carries a primitive out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees import behaviour, common, composites

from .task_parts import TaskParts, failures, most_attempts, successes

Carried = Callable[[str, Mapping[str, Any]], tuple[bool, str]]
"""Function that executes a primitive with its parameters; returns its success, and its result or cause."""


@dataclass
class TreeMemory:
    """State of a task that all behaviours of its tree share, with the present situation and the number of
    Fails of each action.
    """

    situation: str
    fails: dict[int, int] = field(default_factory=dict)


class AtGoal(behaviour.Behaviour):
    """Behaviour of py_trees that succeeds if the task's situation is the goal, and fails otherwise."""

    def __init__(self, memory: TreeMemory, goal: str) -> None:
        super().__init__(f"at {goal}")
        self.memory, self.goal = memory, goal

    def update(self) -> common.Status:
        """Return Success at the goal, otherwise Failure."""
        there = self.memory.situation == self.goal
        return common.Status.SUCCESS if there else common.Status.FAILURE


class DoAction(behaviour.Behaviour):
    """Behaviour of py_trees for one action of a task.

    Its status is Failure in situations in which the action does not start, and Running after the action, so
    that the tree goes on.
    """

    def __init__(self, number: int, row: Mapping[str, Any], memory: TreeMemory, carry: Carried) -> None:
        super().__init__(f"{number} {row['do']}")
        self.number, self.row, self.memory, self._carry = number, dict(row), memory, carry

    def update(self) -> common.Status:
        """Execute this leaf's action and return Running; return Failure if the action cannot start.

        An action can start in its source situation, as long as it has attempts left.
        """
        memory, row, most = self.memory, self.row, most_attempts(self.row)
        is_out = most is not None and memory.fails.get(self.number, 0) >= most
        if memory.situation != row["from"] or is_out:
            return common.Status.FAILURE
        succeeded, word = self._carry(row["do"], row.get("with", {}))
        ends = successes(row) if succeeded else failures(row)
        usual = ends[0][0] if succeeded else ends[-1][0]
        memory.situation = next((to for to, name, _ in ends if word and name == word), usual)
        if not succeeded:
            memory.fails[self.number] = memory.fails.get(self.number, 0) + 1
        return common.Status.RUNNING


class TaskTree(composites.Selector):
    """Behaviour tree of a task, which succeeds at the goal and fails if no action can start any more."""

    def __init__(self, parts: TaskParts, carry: Carried) -> None:
        super().__init__(str(parts.head["title"]), memory=False)
        self.head, self.situations, self.order = dict(parts.head), dict(parts.situations), list(parts.order)
        self.state = TreeMemory(parts.start)
        self.add_child(AtGoal(self.state, parts.goal))
        for number, row in enumerate(parts.actions):
            self.add_child(DoAction(number, row, self.state, carry))


def py_tree(parts: TaskParts, carry: Carried) -> TaskTree:
    """Return a task as a behaviour tree of py_trees.

    Args:
        parts: the task.
        carry: function that the leaves call to execute a primitive, with its name and arguments.
    """
    return TaskTree(parts, carry)


def parts_of_py_tree(tree: TaskTree) -> TaskParts:
    """Return the task from which a py_trees behaviour tree was made, with the leaves' present actions."""
    actions = [child.row for child in tree.children if isinstance(child, DoAction)]
    return TaskParts(tree.head, tree.situations, actions, tree.order)
