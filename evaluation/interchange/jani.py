"""Tasks as models in JANI (Budde and others, 2017), and back; foreign models where they are finite and plain.

A situation is a location, an action an edge with its outcomes as destinations. A bounded variable counts the
Fails of each action. Without `p` Success and Fail are edges of their own, so that their choice is open.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import decode_text, read_regular_file

from .lost import Imported, LostConstruct
from .task_draft import GOAL_NAME, TaskDraft, primitive_name
from .task_parts import TaskParts, failures, led_to, most_attempts, successes

MAX_JANI_BYTES = 1 << 24
COMMENT_PREFIX = "handcart: "
"""Begin of comments with what a model does not express."""
GAVE_UP_NAME = "gave up"
"""Name of the absorbing location of tasks whose actions state `p_give_up`; no situation of the task."""


def model_text(parts: TaskParts) -> str:
    """Return a task as a JANI model, the exchange format of probabilistic model checkers."""
    return json.dumps(_model(parts), indent=1, ensure_ascii=False) + "\n"


def _model(parts: TaskParts) -> dict[str, Any]:
    head = {**parts.head, "order": list(parts.order)}
    has_p = all(p is not None for row in parts.actions for _, _, p in successes(row))
    locations = [
        {"name": name, "comment": COMMENT_PREFIX + json.dumps(facts)}
        for name, facts in parts.situations.items()
    ]
    gave_up = _unused_name(parts.situations)
    if any(row.get("p_give_up") for row in parts.actions):
        locations.append({"name": gave_up})
    edges = [edge for number, row in enumerate(parts.actions) for edge in _edges(number, row, gave_up)]
    return {
        "jani-version": 1,
        "name": str(parts.head["title"]),
        "type": "mdp",
        "metadata": {"description": COMMENT_PREFIX + json.dumps(head)},
        "actions": [{"name": _label(number, row)} for number, row in enumerate(parts.actions)],
        "variables": [
            *_counters(parts),
            {"name": "cost_s", "type": "real", "transient": True, "initial-value": 0},
            {"name": "at_goal", "type": "bool", "transient": True, "initial-value": False},
        ],
        "properties": [_goal_property()] if has_p else [],
        "automata": [
            {
                "name": "task",
                "locations": [_with_goal(location, parts.goal) for location in locations],
                "initial-locations": [parts.start],
                "edges": edges,
            }
        ],
        "system": {"elements": [{"automaton": "task"}]},
    }


def _unused_name(situations: Mapping[str, Any]) -> str:
    """Return a name for the location of GiveUp that no situation has."""
    name = GAVE_UP_NAME
    while name in situations:
        name += " (handcart)"
    return name


def _with_goal(location: dict[str, Any], goal: str) -> dict[str, Any]:
    values = [{"ref": "at_goal", "value": True}]
    return {**location, "transient-values": values} if location["name"] == goal else location


def _goal_property() -> dict[str, Any]:
    reached = {"op": "F", "exp": "at_goal"}
    values = {"op": "filter", "fun": "max", "values": {"op": "Pmax", "exp": reached}}
    return {"name": "P(goal)", "expression": {**values, "states": {"op": "initial"}}}


def _counters(parts: TaskParts) -> Iterator[dict[str, Any]]:
    for number, row in enumerate(parts.actions):
        if most := most_attempts(row):
            yield _counter(number, most)


def _counter(number: int, most: int) -> dict[str, Any]:
    kind = {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": most}
    return {"name": f"fails_{number}", "type": kind, "initial-value": 0}


def _label(number: int, row: Any) -> str:
    return f"{number} {row['do']}"


def _edges(number: int, row: Any, gave_up: str) -> Iterator[dict[str, Any]]:
    """Yield the edges of an action; the first one has what is not expressed as its comment.

    `gave_up` is the location that a GiveUp leads to.
    """
    most = most_attempts(row)
    count: dict[str, Any] = {}
    edge: dict[str, Any] = {"location": row["from"], "action": _label(number, row)}
    if most:
        name = f"fails_{number}"
        edge["guard"] = {"exp": {"op": "<", "left": name, "right": most}}
        count = {"assignments": [{"ref": name, "value": {"op": "+", "left": name, "right": 1}}]}
    well, badly = _outcomes(row)
    good = [({"location": to}, p) for to, p in well]
    bad = [({"location": to, **count}, p) for to, p in badly]
    end = [({"location": gave_up}, row["p_give_up"])] if row.get("p_give_up") else []
    comment = COMMENT_PREFIX + json.dumps({**row, "keys": list(row)})
    if all(p is not None for _, p in good):
        every = [{**to, "probability": {"exp": p}} for to, p in (*good, *bad, *end) if p]
        yield {**edge, "destinations": every, "comment": comment}
        return
    for place, (to, _) in enumerate((*good, *bad, *end)):
        yield {**edge, "destinations": [to], **({} if place else {"comment": comment})}


def import_model(path: Path | str) -> Imported:
    """Convert a JANI model in a file to a task.

    Raises:
        FileError: the file does not contain a JANI model, or it is one that a task cannot express.
    """
    text = decode_text(read_regular_file(path, MAX_JANI_BYTES), str(path), longest_line=None)
    try:
        model = json.loads(text)
        if isinstance(model, Mapping) and "jani-version" in model:
            described = str(model.get("metadata", {}).get("description", ""))
            if described.startswith(COMMENT_PREFIX):
                return Imported(_own(model, described).data(), ())
            return _Foreign(model, Path(path).stem).imported()
        raise ValueError("the key 'jani-version' is missing; needed: a model in JANI")
    except json.JSONDecodeError as error:
        wrong = f"the file is no JSON: {error.msg}; allowed: a model in JANI"
        raise FileError([Finding(str(path), error.lineno, error.colno, wrong)]) from None
    except RecursionError:
        wrong = "the model is nested too deeply; allowed: flatter"
        raise FileError([Finding(str(path), 1, 1, wrong)]) from None
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise FileError([Finding(str(path), 1, 1, f"no usable model: {error}")]) from None


def _own(model: Any, described: str) -> TaskParts:
    head = json.loads(described.removeprefix(COMMENT_PREFIX))
    order, automaton = head.pop("order"), model["automata"][0]
    situations = {
        location["name"]: json.loads(location["comment"].removeprefix(COMMENT_PREFIX))
        for location in automaton["locations"]
        if location.get("comment", "").startswith(COMMENT_PREFIX)
    }
    rows = []
    edges = [item for item in automaton["edges"] if item.get("comment", "").startswith(COMMENT_PREFIX)]
    for edge in edges:
        row = json.loads(edge["comment"].removeprefix(COMMENT_PREFIX))
        keys = row.pop("keys")
        row |= {"do": edge["action"].partition(" ")[2], "from": edge["location"]}
        same = [other for other in automaton["edges"] if other["action"] == edge["action"]]
        row = _led(row, [end["location"] for other in same for end in other["destinations"]])
        rows.append({key: row[key] for key in dict.fromkeys((*keys, *row))})
    return TaskParts(head, situations, rows, order)


def _led(row: Mapping[str, Any], ends: list[str]) -> dict[str, Any]:
    """Return an action that leads to the locations at the ends of its edges; an impossible outcome has no
    end.
    """
    good, bad = _outcomes(row)
    every, is_open = [*good, *bad], any(p is None for _, p in good)
    shown = [place for place, (_, p) in enumerate(every) if is_open or p]
    if len(ends) != len(shown) + bool(row.get("p_give_up")):
        raise ValueError(f"{len(ends)} destinations of {row['do']}; allowed: as many as exported")
    targets = [to for to, _ in every]
    for place, end in zip(shown, ends, strict=False):
        targets[place] = end
    return led_to(row, targets)


def _outcomes(row: Mapping[str, Any]) -> tuple[list[tuple[str, Any]], list[tuple[str, Any]]]:
    """Return next situation and probability of each way of an action's Success, and of its Fail; the
    probability is None where it is open.
    """
    good = [(to, p) for to, _, p in successes(row)]
    bad = [(to, p) for to, _, p in failures(row)]
    if all(p is not None for _, p in good):
        rest = 1.0 - sum(p for _, p in good) - row.get("p_give_up", 0.0) - sum(p or 0.0 for _, p in bad[:-1])
        bad[-1] = bad[-1][0], max(0.0, rest)
    return good, bad


class _Foreign:
    """Model of another program with one automaton, whose locations are the states."""

    def __init__(self, model: Mapping[str, Any], title: str) -> None:
        self._model = model
        self._draft = TaskDraft(str(model.get("name", title)))
        self._lost: dict[LostConstruct, None] = {}

    def imported(self) -> Imported:
        automata = self._model.get("automata", [])
        if len(automata) != 1:
            raise ValueError(f"it has {len(automata)} automata; allowed: one, as others run at the same time")
        automaton = automata[0]
        for key in ("variables", "constants", "properties", "functions", "restrict-initial"):
            if self._model.get(key):
                self._lose(key, "it is dropped")
        if automaton.get("variables"):
            self._lose(f"variables of {automaton.get('name')}", "locations alone are states")
        names = {
            location["name"]: self._draft.situation(location["name"]) for location in automaton["locations"]
        }
        for number, edge in enumerate(automaton["edges"]):
            self._edge(number, edge, names)
        ends = set(names.values()) - {names[item["location"]] for item in automaton["edges"]}
        data = self._draft.data(names[automaton["initial-locations"][0]])
        if len(ends) == 1:  # nothing leads on from the only absorbing location
            data["goal"] = ends.pop()
            data["situations"].pop(GOAL_NAME, None)
        else:
            self._lose("properties", f"{len(ends)} locations have no edges; the goal has to be named")
        return Imported(data, tuple(self._lost))

    def _edge(self, number: int, edge: Mapping[str, Any], names: Mapping[str, str]) -> None:
        label = str(edge.get("action", f"edge {number}"))
        for key in ("guard", "rate", "assignments"):
            if edge.get(key):
                self._lose(f"{key} of edge {number} ({label})", "the edge can always be taken")
        found = []
        for destination in edge["destinations"]:
            p = destination.get("probability", {}).get("exp", 1.0)
            if not isinstance(p, int | float) or isinstance(p, bool):
                self._lose(f"probability of edge {number} ({label})", "it is not a number, and is dropped")
                p = None
            if destination.get("assignments"):
                self._lose(f"assignments of edge {number} ({label})", "variables do not change")
            found.append((names[destination["location"]], p))
        found.sort(key=lambda item: -(item[1] or 0.0))
        then = [{"to": to, "p": p, **({"result": str(n)} if n else {})} for n, (to, p) in enumerate(found)]
        if len(then) == 1 or any(item["p"] is None for item in then):
            self._draft.action(primitive_name(label), names[edge["location"]], found[0][0], p=found[0][1])
        else:
            self._draft.action(primitive_name(label), names[edge["location"]], None, then=then)

    def _lose(self, construct: str, meaning: str) -> None:
        self._lost[LostConstruct(1, 1, construct, meaning)] = None
