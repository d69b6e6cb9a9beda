"""A task's file under construction, from another format."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from handcart.files.errors import InputError

GUESSED_COST_S = 10.0
"""Cost of an action whose format has none, in [s]."""
MAX_DRAFT_ACTIONS = 5_000
"""Maximum number of actions, because retries and nested recoveries multiply."""
GOAL_NAME, FAILED_NAME = "done", "failed"
"""Situations after the Success and after the failure of what was read."""
_NOT_A_NAME = re.compile(r"[^0-9A-Za-z]+")


class TooLargeDraft(InputError):
    """Error for an imported task whose retries and recoveries multiply to too many actions."""

    def __init__(self) -> None:
        wrong = f"with its retries the task has more than {MAX_DRAFT_ACTIONS} actions"
        super().__init__(f"{wrong}; allowed: fewer or smaller retries")


class TaskDraft:
    """Task under construction, whose situations and actions are added one by one."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.head: dict[str, Any] = {}
        """Further keys of the task."""
        self._situations: dict[str, None] = {}
        self._actions: list[dict[str, Any]] = []
        self._counts: Counter[str] = Counter()
        self._same: dict[str, str] = {}
        self._placeholders = 0

    def situation(self, name: str) -> str:
        """Add a situation to the task, and return its name: the given name, with a number if it is taken."""
        plain = found = name.strip() or "here"
        while found in self._situations or found in (GOAL_NAME, FAILED_NAME):
            self._counts[plain] += 1
            found = f"{plain} {self._counts[plain] + 1}"
        self._situations[found] = None
        return found

    def placeholder(self) -> str:
        """Return a new preliminary name of a situation, for actions that are added before `bind` gives the
        situation its final name.
        """
        self._placeholders += 1
        return f"\0{self._placeholders}"

    def bind(self, placeholder: str, situation: str) -> None:
        """Replace a placeholder (see `placeholder`) by a situation or by another placeholder, wherever the
        task names it.
        """
        self._same[placeholder] = situation

    def action(self, do: str, source: str, to: str | None, **more: Any) -> None:
        """Add an action to the task.

        Args:
            do: name of its primitive.
            source: situation in which it starts.
            to: situation after its Success; None: the key is omitted.
            **more: further keys of the action; those with the value None are omitted.

        Raises:
            TooLargeDraft: the task has `MAX_DRAFT_ACTIONS` already.
        """
        if len(self._actions) >= MAX_DRAFT_ACTIONS:
            raise TooLargeDraft
        row = {"do": do, "from": source, "to": to, "cost_s": GUESSED_COST_S, **more}
        self._actions.append({key: value for key, value in row.items() if value is not None})

    def data(self, start: str, backwards: bool = False) -> dict[str, Any]:
        """Return the content of the task's file.

        Args:
            start: situation in which the task begins.
            backwards: True if situations and actions were added in reverse order, the last ones first.
        """
        step = -1 if backwards else 1
        actions = [self._resolved(action) for action in self._actions[::step]]
        used = {name for action in actions for name in _names(action)}
        made = list(self._situations)[::step]
        situations = [item for item in (*made, GOAL_NAME, FAILED_NAME) if item in used]
        begin = self._resolved(start)
        if begin not in situations:
            situations.insert(0, begin)
        return {
            "format": "handcart-task/1",
            "title": self.title,
            **self.head,
            "start": begin,
            "goal": GOAL_NAME,
            "situations": {name: {} for name in dict.fromkeys((*situations, GOAL_NAME))},
            "actions": actions,
        }

    def _resolved(self, part: Any) -> Any:
        """Return a part with situations in place of placeholders."""
        if isinstance(part, str):
            seen: set[str] = set()
            while part in self._same and part not in seen:
                seen.add(part)
                part = self._same[part]
            return FAILED_NAME if part in seen else part  # a loop without a leaf never ends
        if isinstance(part, Mapping):
            return {key: value if key == "with" else self._resolved(value) for key, value in part.items()}
        if isinstance(part, list):
            return [self._resolved(item) for item in part]
        return part


def _names(action: Mapping[str, Any]) -> list[str]:
    """Return the names of the situations between which an action leads."""
    found = [action["from"], action.get("to")]
    found += [item["to"] for item in action.get("then", ())]
    fails = action.get("on_fail")
    found += [fails] if isinstance(fails, str) else [_target(fail) for fail in (fails or {}).values()]
    return [item for item in found if item]


def _target(fail: Any) -> str | None:
    return fail if isinstance(fail, str) else fail.get("to")


def primitive_name(name: str) -> str:
    """Convert a name to the form of primitives' names, from `ComputePath` to COMPUTE_PATH."""
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name)
    return _NOT_A_NAME.sub("_", parted).strip("_").upper() or "ACTION"


def yaml_text(data: Mapping[str, Any], comments: Sequence[str] = ()) -> str:
    """Return the content of a task's file as text, below comments."""
    head = "".join(f"# {line}\n" for comment in comments for line in comment.splitlines())
    text: str = yaml.dump(
        dict(data), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110, default_flow_style=None
    )
    return head + text


class _Dumper(yaml.SafeDumper):
    """Writer without anchors, which task files do not have."""

    def ignore_aliases(self, data: Any) -> bool:
        return True
