"""Tasks as state charts (SCXML, W3C 2015), and back.

A situation is a state that an event `do.N` leaves for the state of action N, which invokes the primitive; its
events `done.success` and `done.fail`, followed by a result or a cause, lead to situations.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any
from xml.sax.saxutils import quoteattr

from .task_parts import TaskParts, failures, led_to, successes
from .xml_tree import XmlElement

XML_NAME = "handcart"
"""Prefix of the attributes with what a state chart does not express."""
SUCCESS_EVENT, FAIL_EVENT = "done.success", "done.fail"


def chart_text(parts: TaskParts) -> str:
    """Return a task as a state chart in the W3C's format SCXML."""
    return "\n".join(_lines(parts)) + "\n"


def _lines(parts: TaskParts) -> Iterator[str]:
    ids = {name: f"s{number}" for number, name in enumerate(parts.situations)}
    head = _json({**parts.head, "order": list(parts.order)})
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield f'<scxml xmlns="http://www.w3.org/2005/07/scxml" xmlns:{XML_NAME}="urn:handcart:task" version="1.0"'
    yield f"       initial={quoteattr(ids[parts.start])} {XML_NAME}:task={head}>"
    for name, facts in parts.situations.items():
        tag = "final" if name == parts.goal else "state"
        named = f"{XML_NAME}:name={quoteattr(name)} {XML_NAME}:facts={_json(facts)}"
        yield f"  <{tag} id={quoteattr(ids[name])} {named}>"
        for number, row in enumerate(parts.actions):
            if row["from"] == name and tag == "state":
                yield f'    <transition event="do.{number}" target="a{number}"/>'
        yield f"  </{tag}>"
    for number, row in enumerate(parts.actions):
        yield from _action(number, row, ids)
    yield "</scxml>"


def _action(number: int, row: Any, ids: dict[str, str]) -> Iterator[str]:
    more = {key: value for key, value in row.items() if key not in ("do", "with")}
    yield f'  <state id="a{number}" {XML_NAME}:action={_json({**more, "keys": list(row)})}>'
    yield f"    <invoke type={quoteattr(XML_NAME)} src={quoteattr(row['do'])}>"
    for name, value in row.get("with", {}).items():
        yield f"      <param name={quoteattr(name)} expr={_json(value)}/>"
    yield "    </invoke>"
    # The longer event first: SCXML takes the first transition that matches.
    for to, result, _ in reversed(successes(row)):
        event = f"{SUCCESS_EVENT}.{result}" if result else SUCCESS_EVENT
        yield f"    <transition event={quoteattr(event)} target={quoteattr(ids[to])}/>"
    for to, cause, _ in failures(row):
        event = f"{FAIL_EVENT}.{cause}" if cause else FAIL_EVENT
        yield f"    <transition event={quoteattr(event)} target={quoteattr(ids[to])}/>"
    yield "  </state>"


def is_own_chart(root: XmlElement) -> bool:
    """Return whether a state chart in SCXML was exported from a handcart task."""
    return f"{XML_NAME}:task" in root.attributes


def parts_of_chart(root: XmlElement) -> TaskParts:
    """Return the task from which a state chart was exported.

    Raises:
        LookupError, TypeError, ValueError: the chart was edited and no longer is a task.
    """
    head = json.loads(root.attributes[f"{XML_NAME}:task"])
    order = head.pop("order")
    places = [child for child in root.children if f"{XML_NAME}:name" in child.attributes]
    names = {place.attributes["id"]: place.attributes[f"{XML_NAME}:name"] for place in places}
    situations = {
        place.attributes[f"{XML_NAME}:name"]: json.loads(place.attributes[f"{XML_NAME}:facts"])
        for place in places
    }
    sources = {
        to.attributes["target"]: names[place.attributes["id"]] for place in places for to in place.children
    }
    actions = [
        _row(child, names, sources) for child in root.children if f"{XML_NAME}:action" in child.attributes
    ]
    return TaskParts(head, situations, actions, order)


def _row(element: XmlElement, names: dict[str, str], sources: dict[str, str]) -> dict[str, Any]:
    row = json.loads(element.attributes[f"{XML_NAME}:action"])
    keys, (invoke, *transitions) = row.pop("keys"), element.children
    targets = {
        transition.attributes["event"]: names[transition.attributes["target"]] for transition in transitions
    }
    row |= {"do": invoke.attributes["src"], "from": sources.get(element.attributes["id"], row["from"])}
    given = {child.attributes["name"]: json.loads(child.attributes["expr"]) for child in invoke.children}
    row |= {"with": given} if given else {}
    events = [f"{SUCCESS_EVENT}.{result}" if result else SUCCESS_EVENT for _, result, _ in successes(row)]
    events += [f"{FAIL_EVENT}.{cause}" if cause else FAIL_EVENT for _, cause, _ in failures(row)]
    row = led_to(row, [targets[event] for event in events])
    return {key: row[key] for key in dict.fromkeys((*keys, *row)) if key in row}


def _json(value: Any) -> str:
    return quoteattr(json.dumps(value, ensure_ascii=False))
