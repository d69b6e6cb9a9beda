"""Tree of a YAML file: values with their lines and columns."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from handcart.files.yaml.scalars import Scalar

KeyPath: TypeAlias = tuple[str | int, ...]
"""Path from the root of a file to a value, as keys and indices such as `("places", 3, "width_mm")`."""


@dataclass(frozen=True, slots=True)
class Node:
    """Value with its line and column (from 1); in a mapping also with those of its key."""

    content: "Scalar | list[Node] | dict[str, Node]"
    file: str
    line: int
    column: int
    key_line: int
    key_column: int

    def child(self, step: str | int) -> "Node | None":
        """Return the value under a key or index, None if there is not one."""
        if isinstance(self.content, dict) and isinstance(step, str):
            return self.content.get(step)
        if isinstance(self.content, list) and isinstance(step, int) and 0 <= step < len(self.content):
            return self.content[step]
        return None

    def deepest(self, path: KeyPath) -> "tuple[Node, bool]":
        """Return the node at `path` and True; if a key is missing, the last node on the way to it and
        False.
        """
        node = self
        for step in path:
            child = node.child(step)
            if child is None:
                return node, False
            node = child
        return node, True

    def plain(self) -> Any:
        """Return the value, with all values in it, as dict, list, str, int, float, bool or None."""
        if isinstance(self.content, dict):
            return {key: child.plain() for key, child in self.content.items()}
        if isinstance(self.content, list):
            return [child.plain() for child in self.content]
        return self.content

    def replaced(self, path: KeyPath, new: "Node") -> "Node":
        """Return a copy of the tree in which `new` is at `path`; the last key of the path may be new.

        Raises:
            KeyError: another key or index of the path is missing.
        """
        if not path:
            return new
        step, rest = path[0], path[1:]
        if isinstance(self.content, dict) and isinstance(step, str) and (not rest or step in self.content):
            old = self.content.get(step)
            changed = old.replaced(rest, new) if old is not None else new
            return self._with({**self.content, step: changed})
        if isinstance(self.content, list) and isinstance(step, int) and 0 <= step < len(self.content):
            items = list(self.content)
            items[step] = items[step].replaced(rest, new)
            return self._with(items)
        raise KeyError(step)

    def _with(self, content: "list[Node] | Mapping[str, Node]") -> "Node":
        kept = content if isinstance(content, list) else dict(content)
        return Node(kept, self.file, self.line, self.column, self.key_line, self.key_column)
