"""A task's file in parts, as other formats hold them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from handcart.files.yaml.yaml_document import parse_document
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import MAX_TASK_NODES, ConditionFile

Row = Mapping[str, Any]
FLOW_KEYS = ("do", "from", "to", "then", "on_fail", "attempts", "with")
"""Keys of an action that the other formats express by themselves."""


@dataclass(frozen=True)
class TaskParts:
    """Content of a task's file, split into situations, actions and other keys, for converting it."""

    head: Mapping[str, Any]
    """All keys but `situations` and `actions`."""
    situations: Mapping[str, Any]
    actions: Sequence[Row]
    order: Sequence[str]
    """All keys in their order."""

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> TaskParts:
        """Split the content of a task's file into situations, actions and other keys."""
        head = {key: value for key, value in data.items() if key not in ("situations", "actions")}
        return cls(head, data["situations"], data["actions"], list(data))

    @classmethod
    def of_task(cls, task: Task) -> TaskParts:
        """Return the content of a task's file, split into situations, actions and other keys.

        If the task's file describes its network by conditions, all situations and actions that follow from
        the conditions are listed.
        """
        document = task.document
        data = parse_document(document.content, document.file, max_nodes=MAX_TASK_NODES).data
        return cls.of_data(_written(task, data) if isinstance(task.file, ConditionFile) else data)

    def data(self) -> dict[str, Any]:
        """Return the content of the task's file, with its keys in their order."""
        every = {**self.head, "situations": dict(self.situations), "actions": [dict(e) for e in self.actions]}
        return {key: every[key] for key in self.order}

    @property
    def start(self) -> str:
        """Name of the situation in which the task starts."""
        return str(self.head["start"])

    @property
    def goal(self) -> str:
        """Name of the situation in which the task ends; of several goals, the last one."""
        goal = self.head["goal"]
        return str(goal[-1] if isinstance(goal, list) else goal)

    def lost(self) -> Iterator[str]:
        """Yield a description of each feature of the task, except comments, that gets lost when its file is
        converted to another format.
        """
        words = {
            "policy": "the policy",
            "belief": "beliefs",
            "time_out_s": "the time-out of the task",
            "interrupts": "interrupts",
            "rounds": "rounds",
            "otherwise": "otherwise",
            "repeat": "repeat: its part is there once",
            "budgets": "shared attempts",
        }
        yield from (meaning for key, meaning in words.items() if key in self.head)
        if isinstance(self.head["goal"], list):
            yield "several goals: the last one alone ends it"
        if any(isinstance(attempts_of(row), Mapping) for row in self.actions):
            yield "attempts that are shared, or given back"
        if any("route_from" in row for row in self.actions):
            yield "the driving times of routes in costs"
        if any("permit" in row for row in self.actions):
            yield "permits of an operator"


def attempts_of(row: Row) -> Any:
    """Return an action's key `attempts`, the limit on its Fails, as in the task file; 3 without the key."""
    return row.get("attempts", 3)


def most_attempts(row: Row) -> int | None:
    """Return the number of Fails after which an action is excluded, by its entry `row` in the task's file.

    None if it is never excluded, or if it shares its attempts with other actions.
    """
    given = attempts_of(row)
    most = given.get("most", None if "budget" in given else 3) if isinstance(given, Mapping) else given
    return most if isinstance(most, int) else None


def successes(row: Row) -> list[tuple[str, str, Any]]:
    """Return next situation, result and probability of each way in which an action can succeed, as its entry
    in the task's file states them.

    The first one is the usual way; the probability is None if the entry does not state it.
    """
    if "then" not in row:
        return [(row["to"], "", row.get("p"))]
    return [(item["to"], item.get("result", ""), item.get("p")) for item in row["then"]]


def failures(row: Row) -> list[tuple[str, str, Any]]:
    """Return next situation, cause and probability of each kind of Fail of an action.

    The last entry, with an empty cause, is for causes that the action does not name.
    """
    given = row.get("on_fail")
    if not isinstance(given, Mapping):
        return [(given or row["from"], "", None)]
    named = [(cause, {"to": item} if isinstance(item, str) else item) for cause, item in given.items()]
    here = row["from"]
    found = [(item.get("to") or here, cause, item.get("p")) for cause, item in named if cause != "else"]
    rest = next((item.get("to") for cause, item in named if cause == "else"), None)
    return [*found, (rest or row["from"], "", None)]


def led_to(row: Row, targets: Sequence[str]) -> dict[str, Any]:
    """Return an action with its next situations replaced.

    Args:
        row: entry of the action in the task's file.
        targets: the next situations, in the order of `successes`, then of `failures`.

    Raises:
        ValueError: the action does not have as many outcomes.
    """
    good, bad = successes(row), failures(row)
    if len(targets) != len(good) + len(bad):
        allowed = f"allowed: {len(good) + len(bad)}, as exported"
        raise ValueError(f"{len(targets)} outcomes of {row['do']}; {allowed}")
    found = dict(row)
    if "then" in row:
        found["then"] = [{**item, "to": to} for item, to in zip(row["then"], targets, strict=False)]
    else:
        found["to"] = targets[0]
    given = row.get("on_fail")
    changed = {
        cause or "else": to
        for (old, cause, _), to in zip(bad, targets[len(good) :], strict=True)
        if to != old
    }
    if changed and isinstance(given, Mapping):
        fails = {cause: _led(item, changed.get(cause)) for cause, item in given.items()}
        found["on_fail"] = {**changed, **fails}
    elif changed:
        found["on_fail"] = changed["else"]
    return found


def _led(fail: Any, to: str | None) -> Any:
    """Return an entry of `on_fail` with its situation replaced by `to`; None: unchanged."""
    if to is None:
        return fail
    return to if isinstance(fail, str) else {**fail, "to": to}


def further_keys(row: Row) -> dict[str, Any]:
    """Return those keys of a task's action, with their values, for which other formats have no element, such
    as cost.
    """
    return {key: value for key, value in row.items() if key not in FLOW_KEYS}


def _written(task: Task, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of a file with the network that conditions span."""
    network = task.network
    kept = {key: value for key, value in data.items() if key not in ("facts", "known", "interrupts")}
    aims = [
        {**given, "goal": interrupt.goals[0]}
        for given, interrupt in zip(data.get("interrupts", ()), network.aims.interrupts, strict=True)
        if interrupt.goals
    ]
    return {
        **kept,
        "start": network.start,
        "goal": network.goal,
        **({"otherwise": list(network.otherwise)} if network.otherwise else {}),
        **({"interrupts": aims} if aims else {}),
        "situations": {situation.name: dict(situation.facts) for situation in network.situations.values()},
        "budgets": {action.budget: action.attempts for action in network.actions if not action.unlimited},
        "actions": [_row(action) for action in network.actions],
    }


def _row(action: Action) -> dict[str, Any]:
    """Return an action of a generated network as its entry in a file would be."""
    row: dict[str, Any] = {"do": action.do, "from": action.source}
    if action.others:
        usual = {"to": action.target, "p": action.p}
        others = [{"to": other.target, "p": other.p, "result": other.result} for other in action.others]
        row["then"] = [_without_none(other) for other in (usual, *others)]
    else:
        row["to"] = action.target
    fails = {ending.cause: {"to": ending.target, "p": ending.p} for ending in action.fail_endings}
    plain = {cause: _without_none(fail) for cause, fail in fails.items()}
    if plain:
        row["on_fail"] = {**plain, **({"else": action.on_fail} if action.on_fail else {})}
    elif action.on_fail:
        row["on_fail"] = action.on_fail
    row["cost_s"] = action.cost_s
    row["attempts"] = "unlimited" if action.unlimited else {"budget": action.budget}
    row |= _without_none(
        {
            "p": None if action.others else action.p,
            "p_give_up": action.p_give_up or None,
            "time_out_s": action.time_out_s,
            "permit": _permit(action),
        }
    )
    given = action.binding.given() if action.binding else {}
    return {**row, "with": given} if given else row


def _permit(action: Action) -> str | None:
    """Return the key `permit` of an action's entry; None where it says what the primitive says."""
    usual = action.binding is not None and action.binding.kind.asks_permission
    if action.permit is usual:
        return None
    return "operator" if action.permit else "none"


def _without_none(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in fields.items() if value is not None}
