"""Editing of values in a user's YAML file, with comments, order and all other values kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq


def edited(text: str, change: Callable[[Any], None]) -> str:
    """Return the text of a YAML file after `change` was applied to its data, with comments and order kept.

    Args:
        text: text of the file.
        change: changes ruamel's data of the file in place.
    """
    yaml = YAML()
    yaml.width = 200
    yaml.preserve_quotes = True
    yaml.indent(mapping=2, sequence=4, offset=2)
    data = yaml.load(text)
    change(data)
    out = StringIO()
    yaml.dump(data, out)
    return out.getvalue()


def flow_list(values: Sequence[float] | Sequence[str]) -> CommentedSeq:
    """Return values as a YAML list in one line, such as [1.0, 2.0]."""
    result = CommentedSeq(values)
    result.fa.set_flow_style()
    return result


def put(data: CommentedMap, key: str, value: Any) -> None:
    """Set a value in the data of a YAML file by its dotted key, in place of an existing value.

    Args:
        data: ruamel's data of the file, which is changed.
        key: such as `arm.accuracy_mm`; missing keys of the path are added after the existing keys.
        value: the value.
    """
    *way, last = key.split(".")
    gap = ""
    for name in way:
        if name not in data:
            gap = gap or _taken_gap(data)
            data[name] = CommentedMap()
        data = data[name]
    if last not in data:
        gap = gap or _taken_gap(data)
    data[last] = value
    if gap:
        data.yaml_add_eol_comment("#", last, column=0)
        data.ca.items[last][2].value = gap


def _taken_gap(data: CommentedMap) -> str:
    """Return the blank lines and complete comment lines behind a mapping's last value, removed from it.

    ruamel attaches them to that value, but they belong after a value that is added.
    """
    last = next(reversed(data), None)
    if last is None:
        return ""
    if isinstance(data[last], CommentedMap):
        return _taken_gap(data[last])
    found = data.ca.items.get(last)
    token = found[2] if found else None
    if token is None:
        return ""
    comment, end, gap = token.value.partition("\n")
    token.value = comment + end
    return end + gap if gap else ""
