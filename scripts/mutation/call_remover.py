"""Mutation operator that removes a call whose result is unused: a stop, a sync, a check."""

from __future__ import annotations

from collections.abc import Iterable

from cosmic_ray.operators.operator import Example, Operator
from parso.python.tree import Keyword
from parso.tree import BaseNode, NodeOrLeaf
from typing_extensions import override

CALL_TYPES = ("atom_expr", "yield_expr", "await")
"""Kinds of nodes that parso gives to a statement `f()`, `yield from f()`, `await f()`."""


class CallRemover(Operator):
    """Replace a statement that is nothing but a call by `pass`."""

    @override
    def mutation_positions(self, node: NodeOrLeaf) -> Iterable[tuple[tuple[int, int], tuple[int, int]]]:
        statement = node.parent is not None and node.parent.type == "simple_stmt"
        if statement and node.type in CALL_TYPES and _calls(node):
            yield node.start_pos, node.end_pos

    @override
    def mutate(self, node: BaseNode, index: int) -> Keyword:
        assert index == 0
        return Keyword("pass", node.start_pos, prefix=node.get_first_leaf().prefix)

    @classmethod
    @override
    def examples(cls) -> Iterable[Example]:
        return (
            Example("def f():\n    stop()\n", "def f():\n    pass\n"),
            Example("def f():\n    yield from a.b(1)\n    c = d()\n", "def f():\n    pass\n    c = d()\n"),
        )


def _calls(node: BaseNode) -> bool:
    """Return whether an expression ends with a call; a lone `yield` passes a period and is left alone."""
    return bool(node.get_last_leaf().value == ")")
