"""Ways to the goal of an activity, as the package `bddl` lists them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from .definition import Definition, Literal


def ground_options(definition: Definition) -> Iterator[list[Literal]]:
    """Yield alternative sets of conditions that fulfil an activity's goal, each as ground literals.

    A ground literal names instances, without variables. If there are many alternatives, the package `bddl`
    lists only a few. Nothing is yielded for a goal that cannot be fulfilled.
    """
    from bddl.activity import get_goal_conditions, get_ground_goal_state_options, get_object_scope

    conditions, backend = definition.conditions, _names_backend()
    scope: dict[str, Any] = get_object_scope(conditions)
    scope.update({term: term for term in scope})
    goal = get_goal_conditions(conditions, backend, scope)
    try:
        options = get_ground_goal_state_options(conditions, backend, scope, goal)
    except AssertionError:  # its only report of a goal without any way
        return
    for option in options:
        yield [_flat(item.body) for item in option]


def _names_backend() -> Any:
    """Return a backend whose predicates have their own names.

    Those of bddl's own `TrivialBackend` (3.6.0) don't: its nextto, touching and contains are called ontop.
    """
    from bddl.backend_abc import BDDLBackend
    from bddl.logic_base import BinaryAtomicFormula, UnaryAtomicFormula
    from bddl.parsing import parse_domain

    from .definition import DOMAIN

    *_, predicates = parse_domain(DOMAIN)

    class PredicateNames(BDDLBackend):  # type: ignore[misc]
        def get_predicate_class(self, predicate_name: str) -> Any:
            is_unary = len(predicates[predicate_name]) == 1
            base = UnaryAtomicFormula if is_unary else BinaryAtomicFormula
            never = {"_evaluate": _never, "_sample": _never}
            return type(f"Named_{predicate_name}", (base,), {"STATE_NAME": predicate_name, **never})

    return PredicateNames()


def _never(*_: Any) -> bool:
    """Return False: names are neither evaluated nor sampled."""
    return False


def _flat(body: Iterable[Any]) -> Literal:
    predicate, *rest = body
    if predicate == "not":
        return ("not", *_flat(rest[0]))
    return (predicate, *(item.lstrip("?") for item in rest))
