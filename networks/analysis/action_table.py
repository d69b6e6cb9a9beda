"""An action network written as a table of primitives with a next one for OK and for Fail, as in paper 003."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, Self

import networkx as nx
from pydantic import Field, model_validator

from handcart.files.errors import Finding
from handcart.files.models.loading import Loaded
from handcart.files.models.model import FileModel
from handcart.networks.chains.absorbing_chain import Absorption, absorption

Fact = str | bool | int | float


class TableRow(FileModel):
    """Row of a network's table of primitives, with a primitive and the numbers of the rows that follow its
    Success and its Fail.
    """

    do: str
    ok: int
    """Number of the row that follows Success."""
    fail: int
    """Number of the row that follows Fail."""
    facts: Annotated[dict[str, Fact], Field(default_factory=dict)]
    """Physical facts that hold where the row begins, as far as they are known."""


class ActionTable(FileModel):
    """An action network written as a table of primitives, with the next row after Success and after Fail."""

    format: Literal["handcart-table/1"]
    title: str
    start: int
    rows: dict[int, TableRow]
    ends: dict[int, str]
    """Ends of a run, GOAL or GIVEUP, by the number of the row."""
    requires: Annotated[list[str], Field(default_factory=list)]
    """Primitives that the task needs."""

    @model_validator(mode="after")
    def _starts(self) -> Self:
        if self.start not in self.rows:
            allowed = ", ".join(map(str, self.rows))
            raise ValueError(f"unknown start row {self.start}; allowed: {allowed}")
        return self


def table_errors(loaded: Loaded[ActionTable]) -> list[Finding]:
    """Return the errors of an action table (numbered rows, each with the rows after Success and after Fail).

    Errors are references to missing rows, and Fails that change physical facts.
    """
    table = loaded.value
    findings = []
    for number, row in table.rows.items():
        for key, to in (("ok", row.ok), ("fail", row.fail)):
            if to not in table.rows and to not in table.ends:
                words = f"row {number} leads to row {to}, which is missing; needed: a row {to}"
                findings.append(loaded.finding(("rows", str(number), key), words))
        wrong = _other_facts(table, number, row)
        if wrong:
            findings.append(loaded.finding(("rows", str(number), "fail"), wrong))
    return findings


def table_warnings(loaded: Loaded[ActionTable]) -> list[Finding]:
    """Return warnings about an action table: missing primitives, endless loops, and Fails that lead to giving
    up.

    An action table is a network written as rows, each with a primitive and the rows after Success and Fail.
    """
    table = loaded.value
    findings = []
    for number, row in table.rows.items():
        end = table.ends.get(row.fail, "")
        if end.upper().replace("_", "") == "GIVEUP":
            said = f"Fail of row {number} leads to {end}, but after a Fail everything is as it was"
            words = f"{said}; needed: a third outcome for giving up"
            findings.append(loaded.finding(("rows", str(number), "fail"), words))
    missing = sorted(set(table.requires) - {row.do for row in table.rows.values()})
    findings += [
        loaded.finding(("requires",), f"{name} is required and has no row; needed: a row that does {name}")
        for name in missing
    ]
    for loop in _loops(table):
        way = " to ".join(map(str, [*loop, loop[0]]))
        words = f"a loop without a bound: {way}; needed: attempts that are limited"
        findings.append(loaded.finding(("rows", str(loop[0])), words))
    return findings


def _other_facts(table: ActionTable, number: int, row: TableRow) -> str:
    after = table.rows.get(row.fail)
    if after is None:
        return ""
    both = row.facts.keys() & after.facts.keys()
    other = [name for name in sorted(both) if row.facts[name] != after.facts[name]]
    if not other:
        return ""
    differences = ", ".join(f"{name}: {row.facts[name]}, there {after.facts[name]}" for name in other)
    said = f"Fail of row {number} leads to row {row.fail}, where other facts hold ({differences})"
    return f"{said}; needed: a row with the same facts, because a Fail changes none"


def _loops(table: ActionTable) -> list[list[int]]:
    graph: nx.DiGraph[int] = nx.DiGraph()
    for number, row in table.rows.items():
        graph.add_edges_from((number, to) for to in (row.ok, row.fail) if to in table.rows)
    loops = []
    for loop in nx.simple_cycles(graph):
        first = loop.index(min(loop))
        loops.append([*loop[first:], *loop[:first]])
    return sorted(loops)


def table_absorption(table: ActionTable, p: float) -> Absorption:
    """Return the probabilities of the ends of runs by an action table, and their mean number of primitives.

    An action table is a network written as rows, each with a primitive and the rows after Success and Fail.

    Each primitive succeeds with probability `p`, and Fails otherwise.
    """
    rows: dict[str, Mapping[str, float]] = {}
    for number, row in table.rows.items():
        chances: dict[str, float] = {}
        for to, share in ((row.ok, p), (row.fail, 1.0 - p)):
            name = table.ends.get(to, f"row {to}")
            chances[name] = chances.get(name, 0.0) + share
        rows[f"row {number}"] = chances
    return absorption(rows, f"row {table.start}")
