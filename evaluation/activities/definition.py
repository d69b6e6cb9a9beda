"""Definition of a household activity, read by the package `bddl`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handcart.files.errors import FileError, Finding, InputError
from handcart.files.suggest import suggest

DOMAIN = "omnigibson"
"""Domain file of the package that names the predicates of BEHAVIOR-1K."""
WILDCARD = "_*"
"""End of a term that stands for all further instances in a scene; our scenes have none."""
Literal = tuple[str, ...]
"""A predicate and its terms, such as ("ontop", "book.n.02_1", "table.n.02_1")."""


class NoBddl(InputError):
    """Error for the package `bddl`, which has the activities, if it is missing or cannot be imported."""

    def __init__(self, why: object) -> None:
        super().__init__(
            f"the activities of BEHAVIOR-1K can't be read: {why}; to install: pip install 'handcart[bddl]'"
        )


@dataclass(frozen=True)
class Definition:
    """Things, initial state and goal of a BEHAVIOR-1K activity, and the BDDL text they were read from."""

    name: str
    instance: int
    path: Path
    text: str
    terms: Mapping[str, Sequence[str]]
    """Names of the instances, by their category (a WordNet synset)."""
    initial: tuple[Literal, ...]
    """Initial conditions, without rooms; one that must not hold begins with "not"."""
    conditions: Any
    """The `bddl.activity.Conditions`."""

    def category(self, term: str) -> str:
        """Return the category of a thing, such as `book.n.02` for the term `book.n.02_1`."""
        return next(category for category, terms in self.terms.items() if term in terms)

    def finding(self, words: Iterable[str], message: str) -> Finding:
        """Return a finding whose place (line and column) is where given words are in the definition's text.

        Args:
            words: words in their order in the text, such as a condition; if the text does not have them, the
                finding is at the first line.
            message: text of the finding.
        """
        pattern = r"[\s()?]+".join(re.escape(word) for word in words)
        found = re.search(r"(?<![\w.])\??" + pattern + r"(?![\w.])", self.text, re.IGNORECASE)
        start = found.start() if found else 0
        line = self.text.count("\n", 0, start) + 1
        return Finding(str(self.path), line, start - self.text.rfind("\n", 0, start), message)

    def goal_words(self) -> set[str]:
        """Return every word of the goal: predicates, terms and categories."""
        return {item.lstrip("?") for item in _flat(self.conditions.parsed_goal_conditions)}


def load_definition(name: str, instance: int = 0) -> Definition:
    """Return the definition of a household activity of BEHAVIOR-1K, from the package `bddl`.

    Args:
        name: name of the activity in the package, such as "re_shelving_library_books".
        instance: number of one of the activity's definitions, from 0; most activities have only the first.

    Raises:
        NoBddl: the package is missing.
        FileError: no activity has this name, or it has no such instance.
    """
    activity, config = _bddl()
    names = sorted(activity.get_all_activities())
    if name not in names:
        raise FileError([Finding("BEHAVIOR-1K", 0, 0, f"unknown activity {name!r}{suggest(name, names)}")])
    path = Path(config.get_definition_filename(name, instance))
    if not path.is_file():
        last = activity.get_instance_count(name) - 1
        allowed = f"0 to {last}" if last else "0"
        raise FileError([Finding(name, 0, 0, f"no definition {instance}; allowed: {allowed}")])
    conditions = activity.Conditions(name, instance, DOMAIN)
    terms = {
        category: tuple(item for item in every if not item.endswith(WILDCARD))
        for category, every in conditions.parsed_objects.items()
    }
    conditions.parsed_objects = {category: list(every) for category, every in terms.items()}
    initial = [_literal(condition) for condition in conditions.parsed_initial_conditions]
    known = tuple(
        literal
        for literal in initial
        if "inroom" not in literal and not any(word.endswith(WILDCARD) for word in literal)
    )
    return Definition(name, instance, path, path.read_text(encoding="utf-8"), terms, known, conditions)


def activity_names() -> list[str]:
    """Return the names of all activities, in alphabetical order.

    Raises:
        NoBddl: the package `bddl` is missing or cannot be imported.
    """
    return sorted(_bddl()[0].get_all_activities())


def _bddl() -> tuple[Any, Any]:
    try:
        import bddl.activity
        import bddl.config
    except ImportError as error:
        raise NoBddl(error) from None
    return bddl.activity, bddl.config


def _literal(condition: Sequence[Any]) -> Literal:
    if condition[0] == "not":
        return ("not", *condition[1])
    return tuple(condition)


def _flat(nested: Any) -> Iterator[str]:
    if isinstance(nested, str):
        yield nested
    else:
        for item in nested:
            yield from _flat(item)
