"""Tasks as behaviour trees of BehaviorTree.CPP, version 4, and back.

The tree keeps the situation and the Fails of each action on its blackboard. In each cycle it does the first
action that starts in the situation and has attempts left; the actions are in the order of the file. A
primitive is a leaf with its parameters as ports; its output ports `cause` and `result` say how it ended.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence, Set
from typing import Any
from xml.sax.saxutils import quoteattr

from .bt_import import VERBOSE_TAGS
from .lost import LostConstruct
from .task_parts import TaskParts, attempts_of, failures, further_keys, most_attempts, successes
from .xml_tree import XmlElement

TASK_PORT, ROW_PORT = "_handcart_task", "_handcart"
"""Attributes for what a tree cannot express; BehaviorTree.CPP ignores names that begin with an underscore."""
CAUSE_PORT, RESULT_PORT = "cause", "result"
_CONDITION = re.compile(r"situation == '((?:[^'])*)'")
_CHOSEN = re.compile(r"\((cause|result) == '([^']*)'\) \? '([^']*)' : ")
_ATTEMPTS = re.compile(r"fails_\d+ < (\d+)")
_LAST = re.compile(r"'([^']*)'\)*$")


def tree_text(parts: TaskParts) -> str:
    """Return a task as a behaviour tree in the XML of BehaviorTree.CPP."""
    return "\n".join(_lines(parts)) + "\n"


def _lines(parts: TaskParts) -> Iterator[str]:
    head = {**parts.head, "situations": parts.situations, "order": list(parts.order)}
    counts = "; ".join(f"fails_{number} := 0" for number in range(len(parts.actions)))
    begin = f"situation := {_quoted(parts.start)}; cause := ''; result := ''; {counts}"
    at_goal = f"situation == {_quoted(parts.goal)}"
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield '<root BTCPP_format="4" main_tree_to_execute="task">'
    yield '  <BehaviorTree ID="task">'
    yield f"    <Sequence name={quoteattr(str(parts.head['title']))} {TASK_PORT}={_json(head)}>"
    yield f"      <Script code={quoteattr(begin)}/>"
    yield "      <ForceSuccess>"
    yield '        <Repeat num_cycles="-1">'
    yield "          <Sequence>"
    yield f"            <ScriptCondition code={quoteattr('!(' + at_goal + ')')}/>"
    yield "            <Fallback>"
    for number, row in enumerate(parts.actions):
        yield from _action(number, row)
    yield "            </Fallback>"
    yield "          </Sequence>"
    yield "        </Repeat>"
    yield "      </ForceSuccess>"
    yield f"      <ScriptCondition code={quoteattr(at_goal)}/>"
    yield "    </Sequence>"
    yield "  </BehaviorTree>"
    yield from _model(parts)
    yield "</root>"


def _action(number: int, row: Any) -> Iterator[str]:
    most = most_attempts(row)
    allowed = "" if most is None else f" && fails_{number} < {most}"
    more = {**further_keys(row), **_forms(row), "keys": list(row)}
    starts = f"situation == {_quoted(row['from'])}{allowed}"
    done = f"situation := {_choice(successes(row)[1:], RESULT_PORT, successes(row)[0][0])}"
    *named, (other, _, _) = failures(row)
    failed = f"fails_{number} := fails_{number} + 1; situation := {_choice(named, CAUSE_PORT, other)}"
    ports = "".join(f" {name}={quoteattr(_port(value))}" for name, value in row.get("with", {}).items())
    outcome = f' {CAUSE_PORT}="{{{CAUSE_PORT}}}" {RESULT_PORT}="{{{RESULT_PORT}}}"'
    space = " " * 14
    yield f'{space}<Sequence name="{number} {row["do"]}" {ROW_PORT}={_json(more)}>'
    yield f"{space}  <ScriptCondition code={quoteattr(starts)}/>"
    yield f"{space}  <Fallback>"
    yield f"{space}    <Sequence>"
    yield f"{space}      <{row['do']}{ports}{outcome}/>"
    yield f"{space}      <Script code={quoteattr(done)}/>"
    yield f"{space}    </Sequence>"
    yield f"{space}    <Script code={quoteattr(failed)}/>"
    yield f"{space}  </Fallback>"
    yield f"{space}</Sequence>"


def _forms(row: Any) -> dict[str, Any]:
    """Return the parts of `then`, `on_fail` and `attempts` that the tree does not express."""
    forms: dict[str, Any] = {"attempts": attempts_of(row)}
    if "then" in row:
        forms["then"] = [{key: value for key, value in item.items() if key != "to"} for item in row["then"]]
    if isinstance(row.get("on_fail"), dict):
        forms["on_fail"] = row["on_fail"]
    return forms


def _choice(named: Sequence[tuple[str, str, Any]], port: str, other: str) -> str:
    """Return the situation by the value of a port, as a script, in which choices need brackets."""
    chosen = _quoted(other)
    for place, (to, name, _) in enumerate(reversed(named)):
        rest = f"({chosen})" if place else chosen
        chosen = f"({port} == {_quoted(name)}) ? {_quoted(to)} : {rest}"
    return chosen


def _model(parts: TaskParts) -> Iterator[str]:
    """Yield the ports of all leaves, which editors and checks of the tree need."""
    ports: dict[str, dict[str, None]] = {}
    for row in parts.actions:
        ports.setdefault(row["do"], {}).update(dict.fromkeys(row.get("with", {})))
    yield "  <TreeNodesModel>"
    for name, inputs in ports.items():
        yield f"    <Action ID={quoteattr(name)}>"
        yield from (f"      <input_port name={quoteattr(input_)}/>" for input_ in inputs)
        yield from (f'      <output_port name="{item}"/>' for item in (CAUSE_PORT, RESULT_PORT))
        yield "    </Action>"
    yield "  </TreeNodesModel>"


def is_own_tree(root: XmlElement) -> bool:
    """Return whether a file of BehaviorTree.CPP was exported from a handcart task."""
    return _top(root) is not None


def parts_of_tree(root: XmlElement) -> TaskParts:
    """Return the parts of the task's file from which a behaviour tree was exported, out of the tree itself.

    Raises:
        LookupError, TypeError, ValueError: the tree was edited and no longer is a task.
    """
    top = _top(root)
    assert top is not None
    head = json.loads(top.attributes[TASK_PORT])
    situations, order = head.pop("situations"), head.pop("order")
    rows = [descendant for descendant in _descendants(top) if ROW_PORT in descendant.attributes]
    declared = {
        (action.attributes["ID"], port.attributes["name"])
        for model in root.children
        if model.tag == "TreeNodesModel"
        for action in model.children
        for port in action.children
    }
    return TaskParts(head, situations, [_row(row, declared) for row in rows], order)


def changed_leaves(root: XmlElement) -> Iterator[LostConstruct]:
    """Yield the leaves that belong to no action of the task, in a behaviour tree that was exported and then
    edited.
    """
    top = _top(root)
    rows = (
        [descendant for descendant in _descendants(top) if ROW_PORT in descendant.attributes] if top else []
    )
    inside = {id(below) for row in rows for below in _descendants(row)}
    known = {"Sequence", "Script", "ForceSuccess", "Repeat", "ScriptCondition", "Fallback"}
    for descendant in _descendants(top) if top else ():
        if id(descendant) not in inside and descendant.tag not in known:
            yield LostConstruct(
                descendant.line,
                descendant.column,
                f"<{descendant.tag}>",
                "it belongs to no action of the task",
            )


def _row(element: XmlElement, declared: Set[tuple[str, str]]) -> dict[str, Any]:
    """Return an action from the part of a tree that does it.

    Args:
        element: the part of the tree.
        declared: ports of each leaf. A `name` that is none of them was added by an editor.
    """
    more = json.loads(element.attributes[ROW_PORT])
    condition, fallback = element.children
    sequence, failed = fallback.children
    leaf, done = sequence.children
    ports = dict(leaf.attributes)
    name = ports.pop("ID", leaf.tag) if leaf.tag in VERBOSE_TAGS else leaf.tag
    (source,) = _CONDITION.findall(condition.attributes["code"])
    own = {key for key in ports if key.startswith("_") or (key == "name" and (name, key) not in declared)}
    given = {key: _value(text) for key, text in ports.items() if key not in (CAUSE_PORT, RESULT_PORT, *own)}
    row = {**more, "do": name, "from": source, **({"with": given} if given else {})}
    row |= _successes(done.attributes["code"], more)
    row |= _failures(failed.attributes["code"], more, source)
    most = _ATTEMPTS.findall(condition.attributes["code"])
    if most and isinstance(more["attempts"], int):
        row["attempts"] = int(most[0])
    keys = dict.fromkeys((*more["keys"], *(["with"] if given else []), "on_fail"))
    return {key: row[key] for key in keys if key in row}


def _successes(code: str, more: dict[str, Any]) -> dict[str, Any]:
    usual = _LAST.findall(code)[-1]
    if "then" not in more:
        return {"to": usual}
    chosen = {result: to for _, result, to in _CHOSEN.findall(code)}
    first, *others = more["then"]
    return {"then": [{"to": usual, **first}, *({"to": chosen[other["result"]], **other} for other in others)]}


def _failures(code: str, more: dict[str, Any], source: str) -> dict[str, Any]:
    other = _LAST.findall(code)[-1]
    if "on_fail" not in more["keys"]:
        return {} if other == source else {"on_fail": other}
    if "on_fail" not in more:
        return {"on_fail": other}
    to = {**{cause: situation for _, cause, situation in _CHOSEN.findall(code)}, "else": other}
    return {"on_fail": {cause: _led(item, to[cause]) for cause, item in more["on_fail"].items()}}


def _led(fail: Any, to: str) -> Any:
    """Return an entry of `on_fail` with its situation replaced by `to`."""
    return to if isinstance(fail, str) else {**fail, "to": to} if "to" in fail else fail


def _top(root: XmlElement) -> XmlElement | None:
    return next((descendant for descendant in _descendants(root) if TASK_PORT in descendant.attributes), None)


def _descendants(element: XmlElement) -> Iterator[XmlElement]:
    for child in element.children:
        yield child
        yield from _descendants(child)


def _port(value: Any) -> str:
    """Return a parameter as a port: a looked-up value is an entry of the blackboard."""
    if isinstance(value, dict) and len(value) == 1:
        (kind, name), *_ = value.items()
        if kind in ("model", "parameter", "each") and isinstance(name, str):
            return f"{{{kind}.{name}}}"
    return value if isinstance(value, str) and not _is_ambiguous(value) else json.dumps(value)


def _value(text: str) -> Any:
    """Return the parameter that a port was written from."""
    found = re.fullmatch(r"\{(model|parameter|each)\.(.+)\}", text)
    if found:
        return {found[1]: found[2]}
    return json.loads(text) if _is_ambiguous(text) else text


def _is_ambiguous(text: str) -> bool:
    """Return whether a text would be read as another value."""
    try:
        json.loads(text)
    except ValueError:
        return bool(re.fullmatch(r"\{(model|parameter|each)\.(.+)\}", text))
    return True


def _quoted(name: str) -> str:
    """Return a name in quotes for a script of a behaviour tree, which has no escapes; names with such quotes
    are rejected.
    """
    if "'" in name:
        raise ValueError(f"the name {name!r} contains a quotation mark; allowed: none in scripts")
    return f"'{name}'"


def _json(value: Any) -> str:
    return quoteattr(json.dumps(value, ensure_ascii=False))
