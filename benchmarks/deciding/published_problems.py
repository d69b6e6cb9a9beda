"""Published planning problems with chance, as state spaces.

Problems of the International Probabilistic Planning Competitions 2006 and 2008, with the optimal values of
the Quantitative Verification Benchmark Set (Hartmanns, Klauck, Parker, Quatmann and Ruijters, 2019).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from fractions import Fraction
from typing import NamedTuple

State = frozenset[str]
Outcomes = list[tuple[Fraction, State]]


class Problem(NamedTuple):
    """A problem whose best probability of the goal is known."""

    name: str
    start: State
    is_goal: Callable[[State], bool]
    actions: Callable[[State], Iterator[Outcomes]]
    """Returns what each possible action leads to."""
    optimum: Fraction


TRIANGLE_ROADS = ("11-12", "12-13", "11-21", "12-22", "21-12", "22-13", "21-31", "31-22")
TIRE_ROADS = [
    "0-12",
    "0-16",
    "1-2",
    "1-3",
    "3-4",
    "3-13",
    "3-14",
    "5-8",
    "5-10",
    "5-16",
    "6-14",
    "7-9",
    "7-13",
    "8-9",
    "9-12",
    "9-16",
    "10-12",
    "10-13",
    "11-16",
    "12-16",
    "13-15",
    "14-16",
]
BLOCK_NAMES = "12345"


def problems() -> list[Problem]:
    """Return the problems."""
    both = {*TIRE_ROADS, *("-".join(reversed(road.split("-"))) for road in TIRE_ROADS)}
    spares = {f"spare {place}" for place in (4, 5, 7, 8, 10, 12, 16)}
    blocks = {"on 1 4", "table 2", "on 3 2", "on 4 5", "table 5", "clear 1", "clear 3", "hand", "firm"}
    blocks |= {f"{word} {block}" for word in ("charged", "whole") for block in BLOCK_NAMES}
    return [
        Problem(
            "triangle-tireworld.9",
            frozenset({"at 11", "good", "spare 21", "spare 22", "spare 31"}),
            lambda state: "at 13" in state,
            lambda state: _drive(state, TRIANGLE_ROADS, Fraction(1, 2), Fraction(1)),
            Fraction(1),
        ),
        Problem(
            "tireworld.17",
            frozenset({"at 2", "good", *spares}),
            lambda state: "at 0" in state,
            lambda state: _drive(state, both, Fraction(2, 5), Fraction(1, 2)),
            Fraction(729, 3125),
        ),
        Problem(
            "exploding-blocksworld.5",
            frozenset(blocks),
            lambda state: {"on 2 4", "table 4"} <= state,
            _stack,
            Fraction(9, 10),
        ),
    ]


def _drive(state: State, roads: Collection[str], flat: Fraction, changes: Fraction) -> Iterator[Outcomes]:
    """Drive, with a flat tyre now and then; load a spare tyre; change to it."""
    place = next(fact[3:] for fact in state if fact.startswith("at "))
    if "good" in state:
        for road in sorted(roads):
            source, target = road.split("-")
            if source == place:
                there = state - {f"at {place}"} | {f"at {target}"}
                yield [(1 - flat, there), (flat, there - {"good"})]
    if f"spare {place}" in state:
        yield [(Fraction(1), state - {f"spare {place}"} | {"loaded"})]
    if "loaded" in state:
        yield [(changes, state - {"loaded"} | {"good"}), (1 - changes, state)]


def _stack(state: State) -> Iterator[Outcomes]:
    """Take and set down blocks; a charged one may destroy the table or the block that it is put on."""
    held = next((block for block in BLOCK_NAMES if f"held {block}" in state), None)
    if held is None:
        for block in BLOCK_NAMES:
            if f"clear {block}" in state and f"whole {block}" in state:
                yield from _take(state, block)
        return
    down = state - {f"held {held}"} | {"hand", f"clear {held}"}
    if "firm" in state:
        there = down | {f"table {held}"}
        yield _charged(there, held, "firm", Fraction(2, 5))
    for block in BLOCK_NAMES:
        if f"clear {block}" in state and f"whole {block}" in state:
            there = down - {f"clear {block}"} | {f"on {held} {block}"}
            yield _charged(there, held, f"whole {block}", Fraction(1, 10))


def _take(state: State, block: str) -> Iterator[Outcomes]:
    free = state - {"hand", f"clear {block}"} | {f"held {block}"}
    if f"table {block}" in state:
        yield [(Fraction(1), free - {f"table {block}"})]
    for under in BLOCK_NAMES:
        if f"on {block} {under}" in state:
            yield [(Fraction(1), free - {f"on {block} {under}"} | {f"clear {under}"})]


def _charged(state: State, block: str, destroyed: str, p: Fraction) -> Outcomes:
    if f"charged {block}" not in state:
        return [(Fraction(1), state)]
    return [(1 - p, state), (p, state - {destroyed, f"charged {block}"})]
