"""What is wrong with the repeated parts of a task."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations

from handcart.files.suggest import listed, suggest
from handcart.files.yaml.yaml_node import KeyPath
from handcart.networks.graph.network import Fact

from .repeating import Copies
from .repetition import Element, Repetition, UnknownElement, found_in, shortened
from .task_model import ActionEntry, Each, GivenFact

Situations = Mapping[str, Mapping[str, GivenFact]]
"""Facts of the situations, by the situation's name."""
Fault = tuple[KeyPath, str]
"""Position in the task's document, and the fault with the allowed values."""


def repeat_faults(
    parts: Sequence[Repetition],
    situations: Situations,
    entries: Mapping[int, ActionEntry],
    start: str,
    goal: str,
) -> Iterator[Fault]:
    """Yield the faults of a task's repeated parts.

    Examples are unknown situations, situations in two parts, and actions that lead into a part at another
    situation than its start.

    Args:
        parts: the repeated parts.
        situations: the file's situations.
        entries: the file's actions, by number.
        start: situation in which the task begins.
        goal: situation in which the task ends.
    """
    for part in parts:
        yield from _unknown(part, situations)
        yield from _entered_elsewhere(part, entries)
        yield from _changed_by_fail(part, situations, entries)
        yield from _changed_by_skip(part, situations)
        inside, begin = part.inner, part.repeat.start
        if start in inside - {begin}:
            yield ("start",), f"is inside the repeated part; allowed there: {begin}"
        if goal in inside - {part.repeat.goal}:
            yield ("goal",), "is inside the repeated part; allowed: its goal, or what lies behind it"
    yield from _in_common(parts, situations)


def _unknown(part: Repetition, situations: Iterable[str]) -> Iterator[Fault]:
    for key, name in (("start", part.repeat.start), ("goal", part.repeat.goal)):
        if name not in situations:
            yield (*part.path, key), f"unknown situation {name!r}{suggest(name, situations)}"


def _entered_elsewhere(part: Repetition, entries: Mapping[int, ActionEntry]) -> Iterator[Fault]:
    """Yield actions that lead from outside into the part past its start."""
    inside = part.inner - {part.repeat.start}
    allowed = f"allowed: {part.repeat.start}, where the part begins"
    for number, entry in entries.items():
        keys = ["to" if entry.then is None else "then"] * len(entry.endings)
        keys += ["on_fail"] * len(entry.fail_situations)
        for key, name in zip(keys, entry.leads_to, strict=True):
            if entry.source not in part.inner and name in inside:
                yield ("actions", number, key), f"leads into the middle of the repeated part; {allowed}"


def _changed_by_fail(
    part: Repetition, situations: Situations, entries: Mapping[int, ActionEntry]
) -> Iterator[Fault]:
    """Yield Fails that end an element, although other facts hold where the next one begins."""
    start, goal = part.repeat.start, part.repeat.goal
    for number, entry in entries.items():
        ends = entry.source in part.inner and goal in entry.fail_situations
        changing = any(isinstance(fact, Each) for fact in situations.get(start, {}).values())
        if ends and (changing or situations.get(entry.source) != situations.get(start)):
            wrong = f"leads to the next element's {start!r}, where other facts hold than in {entry.source!r}"
            yield ("actions", number, "on_fail"), f"{wrong}; allowed: a situation with the same facts"


def _changed_by_skip(part: Repetition, situations: Situations) -> Iterator[Fault]:
    """Yield faults of elements that may be skipped, although other facts hold where the next one begins."""
    changing = [key for key, fact in situations.get(part.repeat.start, {}).items() if isinstance(fact, Each)]
    if part.repeat.unfinished == "skip" and changing:
        wrong = f"skip: in {part.repeat.start!r} {listed(changing)} is another for each element"
        yield (*part.path, "unfinished"), f"{wrong}; allowed: stop"


def element_facts(copies: Copies, situations: Situations) -> tuple[dict[str, dict[str, Fact]], list[Fault]]:
    """Return the facts of a network's situations, with references `{each: ...}` replaced by their values.

    Args:
        copies: the network after copying repeated parts.
        situations: the file's situations, by name, with their facts.

    Returns:
        Facts by the situation's name in the network, and the faults of the references.
    """
    found: dict[str, dict[str, Fact]] = {}
    faults: dict[KeyPath, str] = {}
    for name, (called, element) in copies.situations.items():
        found[name] = {}
        for key, fact in situations[called].items():
            try:
                found[name][key] = _fact(fact, element)
            except UnknownElement as unknown:
                faults.setdefault(("situations", called, key), str(unknown))
    return found, list(faults.items())


def _fact(fact: GivenFact, element: Element | None) -> Fact:
    if not isinstance(fact, Each):
        return fact
    _, value = found_in(fact.each, element)
    if not isinstance(value, str | bool | int | float):
        raise UnknownElement(
            f"{fact.each} is {shortened(value)}; allowed for a fact: a word, a number, true or false"
        )
    return value


def _in_common(parts: Sequence[Repetition], situations: Iterable[str]) -> Iterator[Fault]:
    for before, part in combinations(parts, 2):
        both = [name for name in situations if name in before.inner & part.inner]
        if both and not (before.inner < part.inner or part.inner < before.inner):
            wrong = f"the part shares {listed(map(repr, both))} with the one from {before.repeat.start}"
            allowed = (
                "parts that share no situation, or one within the other; one's goal may be another's start"
            )
            yield (*part.path, "start"), f"{wrong}; allowed: {allowed}"
