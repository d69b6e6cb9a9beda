"""Editing of values in a user's YAML file, with comments, order and all other values kept."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode
from typing_extensions import override

_REST = re.compile(r"(?P<data>[\]},\s]*?(?::(?:\s*\*\S+)?)?\s*?)(?P<comment>(?<=\s)#[^\n]*)?(?P<end>\s*)")
"""What may follow the last value of an item in its line: closing brackets, or an alias, and a comment."""
_GAP = re.compile(r" +(?=#)")
"""Spaces between a value and its comment."""


class _KeepingComposer(Composer):
    """Composer that keeps the comment before a flow collection which has another one behind it.

    ruamel's own composer replaces the first by the second.
    """

    @override
    def compose_sequence_node(self, anchor: Any) -> Any:
        return self._keep_comments(super().compose_sequence_node, anchor)

    @override
    def compose_mapping_node(self, anchor: Any) -> Any:
        return self._keep_comments(super().compose_mapping_node, anchor)

    def _keep_comments(self, compose: Callable[[Any], Any], anchor: Any) -> Any:
        start = self.parser.peek_event()
        before = start.comment
        node = compose(anchor)
        if start.flow_style and before and before[1:] and before[1] and node.comment is not before:
            node.comment = [node.comment[0] if node.comment else None, before[1]]
        return node


def edited(text: str, change: Callable[[Any], None]) -> str:
    """Return the text of a YAML file after `change` was applied to its data, with comments and order kept.

    Args:
        text: text of the file.
        change: changes ruamel's data of the file in place.
    """
    yaml = YAML()
    yaml.Composer = _KeepingComposer
    yaml.width = 200
    yaml.preserve_quotes = True
    yaml.indent(mapping=2, sequence=4, offset=2)
    data = yaml.load(text)
    change(data)
    out = StringIO()
    yaml.dump(data, out)
    return _with_old_lines(text, out.getvalue())


def _with_old_lines(before: str, after: str) -> str:
    """Return the text `after`, with the values that are also in `before` divided into lines as there."""
    old, new = _composed(before), _composed(after)
    if old is None or new is None:
        return after
    pairs = sorted(
        _kept_pairs(old, new, set()), key=lambda pair: (_span(pair[1]).start, -_span(pair[1]).stop)
    )
    text, done = "", 0
    for one, other in pairs:
        there, here = _span(one), _span(other)
        if here.start < done:  # an alias of a part of the value before
            continue
        gaps = _GAP.match(before, there.stop), _GAP.match(after, here.stop)
        ends = [gap.end() for gap in gaps if gap] if all(gaps) else [there.stop, here.stop]
        text += after[done : here.start] + _merged(one, other, before, after) + before[there.stop : ends[0]]
        done = ends[1]
    text += after[done:]
    try:
        return text if _is_same(new, _composed(text)) else after
    except YAMLError:  # lines that are indented too little at their new place
        return after


def _composed(text: str) -> Any:
    """Return the root of a YAML text's nodes; None if it holds comments only."""
    return YAML(typ="safe", pure=True).compose(text)


def _kept_pairs(old: Node, new: Node, seen: set[int]) -> Iterator[tuple[Node, Node]]:
    """Yield the values of two texts whose lines are kept: equal ones, and changed ones in brackets.

    They have the same indentation. Indented lists and mappings are not values in this sense.

    Args:
        old: value in the first text.
        new: value at the same place in the second text.
        seen: identities of values of the second text that were visited; an alias is visited once.
    """
    if id(new) in seen:
        return
    seen.add(id(new))
    if isinstance(new, CollectionNode) and not new.flow_style:
        if type(old) is type(new) and not old.flow_style:
            for one, other in _pairs(old, new):
                yield from _kept_pairs(one, other, seen)
    elif old.start_mark.column == new.start_mark.column and (_is_same(old, new) or _is_extended(old, new)):
        yield old, new


def _is_extended(old: Node, new: Node) -> bool:
    """Return whether a mapping in brackets is an older one with other values, or with further keys behind."""
    if not isinstance(old, MappingNode) or not isinstance(new, MappingNode) or old.anchor != new.anchor:
        return False
    names = [[key.value for key, _ in node.value if isinstance(key, ScalarNode)] for node in (old, new)]
    is_prefix = bool(old.value) and names[0] == names[1][: len(old.value)]
    return is_prefix and bool(old.flow_style) and bool(new.flow_style)


def _merged(old: Node, new: Node, before: str, after: str) -> str:
    """Return the text of a new value, with the lines and comments of an older one as far as possible.

    Args:
        old: older value, in the text `before`.
        new: new value, in the text `after`.
        before: text with the older value.
        after: text with the new value.
    """
    there = _span(old)
    if _is_same(old, new):
        return before[there]
    if not _is_extended(old, new):
        return after[_span(new)]
    text, done = "", there.start
    for (_, one), (_, other) in zip(old.value, new.value, strict=False):
        text += before[done : _span(one).start] + _merged(one, other, before, after)
        done = _span(one).stop
    for key, value in new.value[len(old.value) :]:
        text += f", {after[_span(key).start : _span(value).stop]}"
    return text + before[done : there.stop]


def _pairs(old: CollectionNode, new: CollectionNode) -> Iterator[tuple[Node, Node]]:
    """Yield the values at the same places of two lists, or with the same keys of two mappings."""
    if isinstance(new, SequenceNode):
        yield from zip(old.value, new.value, strict=False)
        return
    values = {key.value: value for key, value in old.value if isinstance(key, ScalarNode)}
    for key, value in new.value:
        if isinstance(key, ScalarNode) and key.value in values:
            yield values[key.value], value


def _is_same(one: Node, other: Node) -> bool:
    """Return whether two values are equal, whatever their lines and quotes."""
    if one.tag != other.tag or one.anchor != other.anchor:
        return False
    if not isinstance(one, CollectionNode):
        return bool(one.value == other.value)
    if len(one.value) != len(other.value):
        return False
    if isinstance(one, SequenceNode):
        return all(map(_is_same, one.value, other.value))
    return all(
        _is_same(key, key_) and _is_same(value, value_)
        for (key, value), (key_, value_) in zip(one.value, other.value, strict=True)
    )


def _span(node: Node) -> slice:
    return slice(node.start_mark.index, node.end_mark.index)


def with_comments(text: str, key: str, comments: Mapping[int, str], earlier: re.Pattern[str]) -> str:
    """Return the text of a YAML file with comments at the ends of items of a list.

    A comment that is there already is kept, and the new one is added to it. An item is left as it is if
    another item follows in its line, or if it is an alias.

    Args:
        text: text of the file.
        key: key of the list at the file's top level.
        comments: comments, each in one line, by the numbers of their items from 0.
        earlier: pattern of what a new comment replaces in an existing one.
    """
    found = next(value for name, value in _composed(text).value if name.value == key)
    lines = text.splitlines(keepends=True)
    for number, comment in comments.items():
        item = found.value[number]
        places = [_place(node.end_mark) for node in _leaves(item)]
        within = [place for place in places if _place(item.start_mark) < place <= _place(item.end_mark)]
        if _place(found.start_mark) <= _place(item.start_mark) <= _place(found.end_mark) and within:
            line, column = max(within)
            lines[line] = lines[line][:column] + _with_comment(lines[line][column:], comment, earlier)
    return "".join(lines)


def _place(mark: Any) -> tuple[int, int]:
    return mark.line, mark.column


def _leaves(node: Node) -> Iterator[Node]:
    """Yield the scalars and flow collections in an indented collection; otherwise the node itself.

    Texts that begin with `|` or `>` and their keys are left out, because a comment behind such a text would
    belong to it; so are empty values, which have no place.
    """
    if not isinstance(node, CollectionNode) or node.flow_style:
        if node.start_mark.index < node.end_mark.index:
            yield node
        return
    for inner in node.value:
        parts = inner if isinstance(inner, tuple) else (inner,)
        if not any(isinstance(part, ScalarNode) and part.style in ("|", ">") for part in parts):
            for part in parts:
                yield from _leaves(part)


def _with_comment(rest: str, comment: str, earlier: re.Pattern[str]) -> str:
    """Return the rest of a line behind a value, with a comment added."""
    ended = _REST.fullmatch(rest)
    if ended is None:
        return rest
    there = ended["comment"]
    if there is None:
        return f"{ended['data'].rstrip()}  # {comment}{ended['end']}"
    changed, count = earlier.subn(lambda _: comment, there, count=1)
    return f"{ended['data']}{changed if count else f'{there.rstrip()}; {comment}'}{ended['end']}"


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
