"""Changing values in a user's YAML file; comments, order and what else stands there are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq


def edited(text: str, change: Callable[[Any], None]) -> str:
    """The text of a file after `change` was applied to its data (ruamel's, as for a round trip)."""
    yaml = YAML()
    yaml.width = 200
    yaml.preserve_quotes = True
    yaml.indent(mapping=2, sequence=4, offset=2)
    data = yaml.load(text)
    change(data)
    out = StringIO()
    yaml.dump(data, out)
    return out.getvalue()


def flow_list(values: Sequence[float]) -> CommentedSeq:
    """Numbers in one line: [1.0, 2.0]."""
    result = CommentedSeq(values)
    result.fa.set_flow_style()
    return result


def put(data: CommentedMap, key: str, value: Any) -> None:
    """Set a value by its dotted key; the mappings on the way are made where they are missing."""
    *way, last = key.split(".")
    for name in way:
        if name not in data:
            _append(data, name, CommentedMap())
        data = data[name]
    if last in data:
        data[last] = value
    else:
        _append(data, last, value)


def _append(data: CommentedMap, key: str, value: Any) -> None:
    """Add a last key; the blank lines behind the one before stay behind it."""
    gap = _taken_gap(data)
    data[key] = value
    if gap:
        _leave_gap(data, key, gap)


def _taken_gap(data: CommentedMap) -> str:
    """The blank lines and comments that ruamel has behind the last value of a mapping, taken from it."""
    last = next(reversed(data), None)
    if last is None:
        return ""
    token = data.ca.items.get(last, [None, None, None])[2]
    if token is None:
        return ""
    comment, end, gap = token.value.partition("\n")
    token.value = comment + end
    return end + gap if gap else ""


def _leave_gap(data: CommentedMap, key: str, gap: str) -> None:
    inner = data[key]
    if isinstance(inner, CommentedMap):
        inner._handcart_gap = gap
        return
    data.yaml_add_eol_comment("#", key, column=0)
    data.ca.items[key][2].value = gap
