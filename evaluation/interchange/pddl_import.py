"""Reading of PDDL domains and problems, also probabilistic ones (PPDDL 1.0), as tasks from conditions.

Predicates are grounded. Those that no action changes are looked up, the others are facts; the network is
generated from them. Actions with conditional effects, quantifiers or disjunctions are skipped and reported.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from handcart.files.errors import FileError, Finding

from .lost import Imported, LostConstruct
from .s_expressions import Expression, read_expressions
from .task_draft import GUESSED_COST_S, MAX_DRAFT_ACTIONS, TooLargeDraft, primitive_name

MAX_BINDINGS = 200_000
"""Maximum number of combinations of objects that are tried for an action."""
Outcome = tuple[float, Mapping[str, bool]]
"""Probability, and the atoms that become true or false."""


class _NotExpressed(Exception):
    """A part of an action or of the goal that conditions cannot express."""

    def __init__(self, expression: Expression, meaning: str) -> None:
        super().__init__(meaning)
        self.expression = expression


class _Action(NamedTuple):
    """A grounded action."""

    name: str
    given: dict[str, str]
    needs: dict[str, bool]
    outcomes: list[Outcome]
    cost_s: float


def import_planning(path: Path | str, problem: Path | str | None = None) -> Imported:
    """Convert a PDDL domain and problem, in one file or two, to a task.

    Raises:
        FileError: domain or problem is missing, or cannot be converted.
    """
    read = [(file, item) for file in (path, problem) if file for item in read_expressions(file)]
    found = {_kind(item): item for _, item in read if item.head == "define"}
    files = {_kind(item): file for file, item in read if item.head == "define"}
    for kind in ("domain", "problem"):
        if kind not in found:
            wrong = f"there is no {kind}; needed: (define ({kind} NAME) ...), here or by --problem"
            raise FileError([Finding(str(path), 1, 1, wrong)])
    try:
        return _Planning(found["domain"], found["problem"]).imported()
    except _NotExpressed as lost:
        wrong = f"{lost.expression.head} in the goal; allowed: a conjunction of atoms"
        here = lost.expression.line, lost.expression.column
        raise FileError([Finding(str(files["problem"]), *here, wrong)]) from None
    except (LookupError, ValueError) as error:
        raise FileError([Finding(str(path), 1, 1, f"no usable domain or problem: {error}")]) from None


def _kind(expression: Expression) -> str:
    return expression.parts[1].head if len(expression.parts) > 1 else ""


class _Planning:
    """Grounding of one PDDL problem."""

    def __init__(self, domain: Expression, problem: Expression) -> None:
        self._lost: dict[LostConstruct, None] = {}
        self._domain, self._problem = _sections(domain), _sections(problem)
        self._name = problem.parts[1].parts[1].word
        self._parents = dict(_typed(self._all(":types")))
        self._objects = dict(_typed([*self._all(":constants"), *self._all(":objects")]))
        self._init: set[str] = set()
        for item in self._all(":init"):
            if item.head in ("=", "probabilistic", "not", ""):
                if item.head != "=":
                    self._lose(item, "it is dropped at the start")
                continue
            self._init.add(_atom(item, {}))

    def imported(self) -> Imported:
        goals = self._all(":goal")
        if not goals:
            raise ValueError("the problem has no :goal")
        schemas = [item for item in self._domain if item.head == ":action"]
        for item in self._domain:
            if item.head in (":durative-action", ":derived", ":functions", ":axiom", ":process", ":event"):
                self._lose(item, "it is dropped")
        changed = {word for schema in schemas for word in self._changed(schema)}
        grounded = [action for schema in schemas for action in self._grounded(schema, changed)]
        actions = self._reachable(grounded)
        atoms = dict.fromkeys(a for item in actions for _, effects in item.outcomes for a in effects)
        actions = [item for item in actions if self._may_hold(item.needs, atoms)]
        goal = self._condition(goals[0], {}, changed)
        if not self._may_hold(goal, atoms):
            raise ValueError("its goal can never hold")
        goal = {atom: truth for atom, truth in goal.items() if atom in atoms}
        used = {atom for item in actions for atom in item.needs} | goal.keys()
        facts = {atom: [atom in self._init, atom not in self._init] for atom in atoms if atom in used}
        return Imported(self._data(facts, goal, actions), tuple(self._lost))

    def _may_hold(self, needs: Mapping[str, bool], atoms: Mapping[str, None]) -> bool:
        """Return whether conditions agree with what no action changes."""
        return all(atom in atoms or (atom and (atom in self._init) is truth) for atom, truth in needs.items())

    def _data(
        self, facts: Mapping[str, list[bool]], goal: Mapping[str, bool], actions: Sequence[_Action]
    ) -> dict[str, Any]:
        has_chances = any(len(action.outcomes) > 1 for action in actions)
        rows = [_row(action, facts, has_chances) for action in actions]
        return {
            "format": "handcart-task/1",
            "title": self._name,
            "facts": dict(facts),
            "goal": dict(goal),
            "actions": [row for row in rows if row["then"]],
        }

    def _all(self, key: str) -> list[Expression]:
        sections = (*self._domain, *self._problem)
        return [part for section in sections if section.head == key for part in section.parts[1:]]

    def _lose(self, expression: Expression, meaning: str) -> None:
        words = str(expression)
        shown = words if len(words) <= 60 else f"{words[:60]} ..."
        self._lost[LostConstruct(expression.line, expression.column, shown, meaning)] = None

    def _changed(self, schema: Expression) -> Iterator[str]:
        """Yield the predicates that an action may change."""
        ahead = [_section(schema, ":effect")]
        while ahead:
            each = ahead.pop()
            if each is not None and each.parts:
                yield each.head
                ahead += each.parts[1:]

    def _grounded(self, schema: Expression, changed: set[str]) -> Iterator[_Action]:
        name = schema.parts[1].word
        parameters = _section(schema, ":parameters")
        typed = list(_typed(parameters.parts if parameters else []))
        choices = [[name for name, kind in self._objects.items() if self._is(kind, t)] for _, t in typed]
        count = 1
        for choice in choices:
            count *= max(1, len(choice))
        if count > MAX_BINDINGS:
            raise TooLargeDraft
        try:
            for objects in product(*choices):
                bound = {variable: object_ for (variable, _), object_ in zip(typed, objects, strict=True)}
                action = self._action(name, schema, bound, changed)
                if action is not None:
                    yield action
        except _NotExpressed as lost:
            self._lose(lost.expression, f"{lost}; the action {name} is dropped")

    def _action(
        self, name: str, schema: Expression, bound: dict[str, str], changed: set[str]
    ) -> _Action | None:
        """Return an action for certain objects; None if it can never start."""
        condition = _section(schema, ":precondition")
        needs = self._condition(condition, bound, changed) if condition else {}
        if needs.pop("", True) is False:
            return None
        effect = _section(schema, ":effect")
        outcomes, cost = self._effect(effect, bound) if effect else ([(1.0, {})], 0.0)
        given = {variable.lstrip("?"): text for variable, text in bound.items()}
        return _Action(name, given, needs, outcomes, cost or GUESSED_COST_S)

    def _condition(
        self, expression: Expression, bound: Mapping[str, str], changed: set[str]
    ) -> dict[str, bool]:
        """Return the atoms that have to be true or false; `{"": False}` if the condition never holds."""
        if expression.head == "and":
            found: dict[str, bool] = {}
            for part in expression.parts[1:]:
                for atom, truth in self._condition(part, bound, changed).items():
                    if found.get(atom, truth) != truth:
                        return {"": False}
                    found[atom] = truth
            return found
        is_true, inner = True, expression
        if expression.head == "not":
            is_true, inner = False, expression.parts[1]
        if inner.head in ("or", "forall", "exists", "imply", "and", "not", "<", ">", "<=", ">="):
            raise _NotExpressed(inner, f"{inner.head} in a condition")
        if inner.head == "=":
            same = _term(inner.parts[1], bound) == _term(inner.parts[2], bound)
            return {} if same is is_true else {"": False}
        if not inner.parts:
            return {}
        atom = _atom(inner, bound)
        if inner.head not in changed:
            return {} if (atom in self._init) is is_true else {"": False}
        return {atom: is_true}

    def _effect(self, expression: Expression, bound: Mapping[str, str]) -> tuple[list[Outcome], float]:
        """Return the outcomes of an effect, and its cost."""
        match expression.head:
            case "and":
                outcomes, cost = [(1.0, dict[str, bool]())], 0.0
                for part in expression.parts[1:]:
                    more, further = self._effect(part, bound)
                    outcomes = [(p * q, _both(one, other)) for p, one in outcomes for q, other in more]
                    cost += further
                return [(p, dict(effects)) for p, effects in outcomes], cost
            case "probabilistic":
                return self._chances(expression, bound)
            case "not":
                return [(1.0, {_atom(expression.parts[1], bound): False})], 0.0
            case "increase" | "decrease":
                return [(1.0, {})], _number(expression)
            case "when" | "forall" | "assign" | "oneof":
                raise _NotExpressed(expression, f"{expression.head} in an effect")
            case "":
                return [(1.0, {})], 0.0
        return [(1.0, {_atom(expression, bound): True})], 0.0

    def _chances(self, expression: Expression, bound: Mapping[str, str]) -> tuple[list[Outcome], float]:
        found: list[Outcome] = []
        pairs = expression.parts[1:]
        for number, effect in zip(pairs[::2], pairs[1::2], strict=True):
            share = _fraction(number.word)
            outcomes, _ = self._effect(effect, bound)
            found += [(share * p, effects) for p, effects in outcomes]
        rest = 1.0 - sum(p for p, _ in found)
        return ([*found, (rest, {})] if rest > 1e-9 else found), 0.0

    def _is(self, kind: str, wanted: str) -> bool:
        """Return whether a type is another one, or below it."""
        for _ in range(len(self._parents) + 1):
            if wanted in (kind, "object"):
                return True
            kind = self._parents.get(kind, "object")
        return wanted == "object"

    def _reachable(self, grounded: Sequence[_Action]) -> list[_Action]:
        """Return the actions whose conditions may hold in some state, if nothing ever becomes false."""
        true, found, left = set(self._init), list[_Action](), list(grounded)
        while True:
            now, later = list[_Action](), list[_Action]()
            for item in left:
                can_start = all(atom in true for atom, needed in item.needs.items() if needed)
                (now if can_start else later).append(item)
            if not now:
                return found
            found += now
            if len(found) > MAX_DRAFT_ACTIONS:
                raise TooLargeDraft
            left = later
            effects = [every for item in now for _, every in item.outcomes]
            true |= {atom for effect in effects for atom, truth in effect.items() if truth}


def _row(action: _Action, facts: Mapping[str, Any], has_chances: bool) -> dict[str, Any]:
    """Return an action as its entry in a task's file."""
    kept = [(p, {a: t for a, t in effects.items() if a in facts}) for p, effects in action.outcomes]
    needs = {atom: truth for atom, truth in action.needs.items() if atom in facts}
    row: dict[str, Any] = {"do": primitive_name(action.name), "if": needs}
    merged: dict[tuple[tuple[str, bool], ...], float] = {}
    for p, effects in kept:
        key = tuple(sorted(effects.items()))
        merged[key] = merged.get(key, 0.0) + p
    usual, *others = sorted(merged.items(), key=lambda item: (-item[1], len(item[0])))
    if others:
        then: Any = [{"p": round(usual[1], 12), **dict(usual[0])}]
        then += [{"p": round(p, 12), "result": str(n), **dict(e)} for n, (e, p) in enumerate(others, start=1)]
    else:
        then = dict(usual[0])
        row |= {"p": 1.0} if has_chances else {}
    return {**row, "then": then, "cost_s": action.cost_s, **({"with": action.given} if action.given else {})}


def _sections(expression: Expression) -> list[Expression]:
    return [part for part in expression.parts[2:] if part.parts]


def _section(schema: Expression, key: str) -> Expression | None:
    """Return the expression after a key of an action."""
    for word, value in zip(schema.parts, schema.parts[1:], strict=False):
        if word.word == key:
            return value
    return None


def _typed(parts: Sequence[Expression]) -> Iterator[tuple[str, str]]:
    """Yield names with their types, of a list like `a b - room c`."""
    waiting: list[str] = []
    words = iter(parts)
    for word in words:
        if word.word == "-":
            kind = next(words, None)
            yield from ((name, kind.word if kind and kind.word else "object") for name in waiting)
            waiting = []
        else:
            waiting.append(word.word)
    yield from ((name, "object") for name in waiting)


def _term(expression: Expression, bound: Mapping[str, str]) -> str:
    word = expression.word
    return bound[word] if word.startswith("?") else word


def _atom(expression: Expression, bound: Mapping[str, str]) -> str:
    """Return a grounded predicate as the name of a fact."""
    terms = [_term(part, bound) for part in expression.parts[1:]]
    return f"{expression.head}({', '.join(terms)})" if terms else expression.head


def _both(one: Mapping[str, bool], other: Mapping[str, bool]) -> dict[str, bool]:
    """Return two effects together: a fact that one makes true is true."""
    return {**one, **other, **{atom: True for atom, truth in one.items() if truth and atom in other}}


def _number(expression: Expression) -> float:
    try:
        return abs(float(expression.parts[2].word))
    except (IndexError, ValueError):
        return 0.0


def _fraction(word: str) -> float:
    above, _, below = word.partition("/")
    value = float(above) / float(below or 1)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"the probability {word}; allowed: 0 to 1")
    return value
