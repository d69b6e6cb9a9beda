"""Node of a behaviour tree, independent of the program that wrote it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class BehaviourNode:
    """Node of a behaviour tree of any format, with the kind of node as BehaviorTree.CPP names it."""

    kind: str
    """Name of a control, decorator or leaf node."""
    name: str = ""
    ports: Mapping[str, str] = field(default_factory=dict)
    children: tuple[BehaviourNode, ...] = ()
    line: int = 0
    column: int = 0
    shown: str = ""
    """The node as its file names it (default: its kind)."""

    @property
    def construct(self) -> str:
        """Name of the node for messages: the name in its file, or one made of its kind and name."""
        return self.shown or (f"{self.kind} {self.name!r}" if self.name else self.kind)
