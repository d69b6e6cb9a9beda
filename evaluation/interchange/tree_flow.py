"""Behaviour trees as networks: where the flow of control goes after each leaf's success and failure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .lost import LostConstruct
from .task_draft import FAILED_NAME, GOAL_NAME, TaskDraft, TooLargeDraft, primitive_name
from .tree_node import BehaviourNode

MAX_RETRIES = 100
MAX_TREE_DEPTH = 200
MAX_VISITS = 500_000
"""Maximum number of nodes, each counted once for each retry, as retries of nothing multiply too."""
IN_ORDER = "its children are done in order, each to its end"
SEQUENCE_TAGS = {
    "Sequence": "",
    "AsyncSequence": "",
    "SequenceWithMemory": "a failed child is not where the sequence begins again",
    "SequenceStar": "a failed child is not where the sequence begins again",
    "ReactiveSequence": f"{IN_ORDER}, and conditions are not looked at meanwhile",
    "PipelineSequence": f"{IN_ORDER}, and earlier ones are not done again meanwhile",
    "Parallel": f"{IN_ORDER}, none at the same time, and all have to succeed",
    "ParallelAll": f"{IN_ORDER}, none at the same time, and all have to succeed",
}
"""Controls whose children all have to succeed, with what is lost."""
FALLBACK_TAGS = {
    "Fallback": "",
    "Selector": "",
    "AsyncFallback": "",
    "ReactiveFallback": "earlier children are not looked at again while a later one runs",
    "RoundRobin": "it begins with its first child each time",
    "ManualSelector": "nobody chooses; its children are tried in order",
}
"""Controls one of whose children has to succeed, with what is lost."""
PASSING_TAGS = {
    "RateController": "its child is done when the flow comes to it, not at a rate",
    "DistanceController": "its child is done when the flow comes to it, not after a distance",
    "SpeedController": "its child is done when the flow comes to it, not by speed",
    "GoalUpdater": "its child is done with the goal as it is",
    "PathLongerOnApproach": "its child is done when the flow comes to it",
    "SingleTrigger": "its child is done each time",
    "GoalUpdatedController": "its child is done when the flow comes to it",
    "KeepRunningUntilFailure": "its child is done once",
    "RunOnce": "its child is done each time",
    "Delay": "its child is done at once",
    "EntryUpdated": "its child is done each time",
}
"""Decorators that only change when or how often their child is ticked, with what is lost."""
Compile = Callable[[BehaviourNode, str, str], str]


class TreeFlow:
    """Translator of a behaviour tree to a task under construction, in which the leaves become actions.

    A situation is a point in the tree between two leaves. An action's `on_fail` leads to the leaf that the
    tree ticks next after a failure. This is allowed because everything is as before the action after a Fail.
    """

    def __init__(self, draft: TaskDraft, trees: Mapping[str, BehaviourNode]) -> None:
        """Prepare the translation.

        Args:
            draft: the task, to be extended.
            trees: roots of the trees that others may contain, by their names.
        """
        self.lost: dict[LostConstruct, None] = {}
        self._draft, self._trees = draft, trees
        self._open: list[str] = []
        self._loops = 0
        self._time_out: float | None = None
        self._depth = 0
        self._visits = 0
        self._own: dict[str, Compile] = {
            "Inverter": lambda node, succ, fail: self._child(node, fail, succ),
            "ForceSuccess": lambda node, succ, _fail: self._child(node, succ, succ),
            "ForceFailure": lambda node, _succ, fail: self._child(node, fail, fail),
            "AlwaysSuccess": lambda _node, succ, _fail: succ,
            "AlwaysFailure": lambda _node, _succ, fail: fail,
            "RetryUntilSuccessful": self._retry,
            "RetryUntilSuccesful": self._retry,  # as older versions spell it
            "Repeat": self._repeat,
            "RecoveryNode": self._recovery,
            "IfThenElse": self._choice,
            "WhileDoElse": self._choice,
            "Timeout": self._timed,
            "SubTree": self._subtree,
            "SubTreePlus": self._subtree,
        }

    def translate(self, tree: str) -> str:
        """Add the actions of a behaviour tree to the task under construction, and return the situation before
        them.
        """
        self._open.append(tree)
        root = self._trees[tree]
        if root.kind in ("Repeat", "KeepRunningUntilFailure") and self._count(root) < 0 and root.children:
            self._draft.head["rounds"] = "forever"
            root = root.children[0]
        begin = self._node(root, GOAL_NAME, FAILED_NAME)
        if begin in (GOAL_NAME, FAILED_NAME):  # a tree without a leaf
            here = self._draft.situation("start")
            self._draft.action("NOTHING", here, begin)
            return here
        return begin

    def _node(self, node: BehaviourNode, succ: str, fail: str) -> str:
        """Add a node; return the situation in which it begins.

        Args:
            node: the node.
            succ: situation after its success.
            fail: situation after its failure.
        """
        self._depth += 1
        self._visits += 1
        if self._visits > MAX_VISITS:
            raise TooLargeDraft
        if self._depth > MAX_TREE_DEPTH:
            self._lose(node, f"it is nested deeper than {MAX_TREE_DEPTH}; it is dropped")
            self._depth -= 1
            return succ
        found = self._compiled(node, succ, fail)
        self._depth -= 1
        return found

    def _compiled(self, node: BehaviourNode, succ: str, fail: str) -> str:
        if node.kind in self._own:
            return self._own[node.kind](node, succ, fail)
        if node.kind in SEQUENCE_TAGS:
            self._lose(node, SEQUENCE_TAGS[node.kind])
            return self._sequence(node.children, succ, fail)
        if node.kind in FALLBACK_TAGS:
            self._lose(node, FALLBACK_TAGS[node.kind])
            return self._fallback(node.children, succ, fail)
        if node.kind in PASSING_TAGS:
            self._lose(node, PASSING_TAGS[node.kind])
            return self._child(node, succ, fail)
        if node.children:
            self._lose(node, "an unknown node with children; they are done in order")
            return self._sequence(node.children, succ, fail)
        return self._leaf(node, succ, fail)

    def _leaf(self, node: BehaviourNode, succ: str, fail: str) -> str:
        here = self._draft.situation(node.name or node.kind)
        given = {key: self._value(node, key, text) for key, text in node.ports.items()}
        self._draft.action(
            primitive_name(node.kind),
            here,
            succ,
            on_fail=fail,
            attempts="unlimited" if self._loops else 1,
            time_out_s=self._time_out,
            **({"with": given} if given else {}),
        )
        return here

    def _value(self, node: BehaviourNode, key: str, text: str) -> Any:
        """Return the value of a node's port; a reference to the blackboard stays as its text."""
        if text.startswith("{") and text.endswith("}"):
            self._lose(node, f"port {key}: the blackboard entry {text} stays as text", f'{key}="{text}"')
            return text
        return plain_value(text)

    def _sequence(self, children: tuple[BehaviourNode, ...], succ: str, fail: str) -> str:
        for child in reversed(children):
            succ = self._node(child, succ, fail)
        return succ

    def _fallback(self, children: tuple[BehaviourNode, ...], succ: str, fail: str) -> str:
        for child in reversed(children):
            fail = self._node(child, succ, fail)
        return fail

    def _child(self, node: BehaviourNode, succ: str, fail: str) -> str:
        return self._sequence(node.children, succ, fail)

    def _retry(self, node: BehaviourNode, succ: str, fail: str) -> str:
        count = self._count(node)
        if count < 0:
            again = self._draft.placeholder()
            self._loops += 1
            begin = self._child(node, succ, again)
            self._loops -= 1
            self._draft.bind(again, begin)
            return begin
        for _ in range(count):
            fail = self._child(node, succ, fail)
        return fail

    def _repeat(self, node: BehaviourNode, succ: str, fail: str) -> str:
        count = self._count(node)
        if count < 0:
            self._lose(node, "it is done once; only a whole tree can be repeated for ever")
            count = 1
        for _ in range(count):
            succ = self._child(node, succ, fail)
        return succ

    def _recovery(self, node: BehaviourNode, succ: str, fail: str) -> str:
        if len(node.children) != 2:
            self._lose(node, "it has not two children; they are done in order")
            return self._sequence(node.children, succ, fail)
        main, recovery = node.children
        begin = self._node(main, succ, fail)
        for _ in range(max(0, self._count(node))):
            begin = self._node(main, succ, self._node(recovery, begin, fail))
        return begin

    def _choice(self, node: BehaviourNode, succ: str, fail: str) -> str:
        if node.kind == "WhileDoElse":
            self._lose(node, "its condition is looked at once")
        if len(node.children) not in (2, 3):
            self._lose(node, "it has not two or three children; they are done in order")
            return self._sequence(node.children, succ, fail)
        condition, then, *otherwise = node.children
        no = self._node(otherwise[0], succ, fail) if otherwise else fail
        return self._node(condition, self._node(then, succ, fail), no)

    def _timed(self, node: BehaviourNode, succ: str, fail: str) -> str:
        text = node.ports.get("msec", node.ports.get("seconds", ""))
        value = plain_value(text)
        single = len(node.children) == 1 and not node.children[0].children
        if not isinstance(value, int | float) or isinstance(value, bool) or value <= 0:
            self._lose(node, f"its time {text!r} is not a number above 0; its child has no time-out")
            return self._child(node, succ, fail)
        if not single or node.children[0].kind in self._trees:
            self._lose(node, "the time-out is that of each leaf in it, not of all together")
        before, self._time_out = self._time_out, value / 1e3 if "msec" in node.ports else float(value)
        begin = self._child(node, succ, fail)
        self._time_out = before
        return begin

    def _subtree(self, node: BehaviourNode, succ: str, fail: str) -> str:
        name = node.ports.get("ID", "")
        if name not in self._trees or name in self._open:
            why = "contains itself" if name in self._open else "is not in the file"
            self._lose(node, f"the tree {name!r} {why}; it is an action")
            return self._leaf(BehaviourNode(name or "SubTree", node.name), succ, fail)
        self._open.append(name)
        given = {key: text for key, text in node.ports.items() if key != "ID"}
        begin = self._node(with_ports(self._trees[name], given), succ, fail)
        self._open.pop()
        return begin

    def _count(self, node: BehaviourNode) -> int:
        keys = ("num_attempts", "num_cycles", "number_of_retries")
        text = next((node.ports[key] for key in keys if key in node.ports), "1")
        value = plain_value(text)
        if node.kind == "KeepRunningUntilFailure":
            return -1
        if not isinstance(value, int) or isinstance(value, bool) or value > MAX_RETRIES:
            self._lose(node, f"its number {text!r} is not a whole number up to {MAX_RETRIES}; it counts as 1")
            return 1
        return value

    def _lose(self, node: BehaviourNode, meaning: str, construct: str = "") -> None:
        if meaning:
            self.lost[LostConstruct(node.line, node.column, construct or node.construct, meaning)] = None


def with_ports(node: BehaviourNode, given: Mapping[str, str]) -> BehaviourNode:
    """Return a subtree in which each port `{name}` is replaced by the value given for `name`.

    Args:
        node: root of the subtree.
        given: values by name; ports with other names are kept.
    """
    if not given:
        return node
    ports = {
        key: given.get(text[1:-1], text) if text.startswith("{") and text.endswith("}") else text
        for key, text in node.ports.items()
    }
    children = tuple(with_ports(child, given) for child in node.children)
    return BehaviourNode(node.kind, node.name, ports, children, node.line, node.column, node.shown)


def plain_value(text: str) -> Any:
    """Convert the text of a behaviour tree's port to a bool or number if it is one, otherwise return the
    text.
    """
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            value = kind(text)
        except ValueError:
            continue
        return value if abs(value) < 1e15 else text
    return text
