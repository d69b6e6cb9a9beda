"""Verdict of BEHAVIOR-1K's own evaluator on the true poses of things."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from .definition import Definition
from .true_relations import TrueThing, is_inside, is_next_to, is_on_top, is_touching, is_under

PREDICATES: Mapping[str, Callable[[TrueThing, TrueThing], bool]] = {
    "ontop": is_on_top,
    "inside": is_inside,
    "nextto": is_next_to,
    "under": is_under,
    "touching": is_touching,
}


class Verdict(NamedTuple):
    """Result of evaluating the goal conditions of an activity, with the conditions that do not hold."""

    holds: bool
    unsatisfied: tuple[str, ...]
    """Conditions that don't hold, in the evaluator's words."""


def judge_goal(definition: Definition, things: Mapping[str, TrueThing]) -> Verdict:
    """Return whether the goal of an activity holds, and which of its conditions do not.

    Args:
        definition: the activity.
        things: true state of each thing, by its term in the definition.

    Raises:
        UnsupportedPredicateError: the definition has a predicate that is not supported.
    """
    from bddl.activity import evaluate_goal_conditions, get_goal_conditions, get_natural_goal_conditions

    conditions = definition.conditions
    compiled = get_goal_conditions(
        conditions, true_pose_backend(), scope_of(definition, things), generate_ground_options=False
    )
    holds, found = evaluate_goal_conditions(compiled)
    words = get_natural_goal_conditions(conditions)
    return Verdict(bool(holds), tuple(" ".join(words[item].split()) for item in found["unsatisfied"]))


def scope_of(definition: Definition, things: Mapping[str, TrueThing]) -> dict[str, Any]:
    """Return the true state of each thing of an activity, by its term; None for those that are missing."""
    from bddl.activity import get_object_scope

    return {term: things.get(term) for term in get_object_scope(definition.conditions)}


def true_pose_backend() -> Any:
    """Return a backend of the package whose predicates compare true poses."""
    from bddl.backend_abc import BDDLBackend

    class TruePoses(BDDLBackend):  # type: ignore[misc]
        def get_predicate_class(self, predicate_name: str) -> Any:
            return _predicate(predicate_name, PREDICATES[predicate_name])

    return TruePoses()


def _predicate(name: str, holds: Callable[[TrueThing, TrueThing], bool]) -> Any:
    from bddl.logic_base import BinaryAtomicFormula

    class TrueRelation(BinaryAtomicFormula):  # type: ignore[misc]
        STATE_NAME = name

        def _evaluate(self, obj1: TrueThing, obj2: TrueThing) -> bool:
            return bool(holds(obj1, obj2))

        def _sample(self, obj1: TrueThing, obj2: TrueThing, binary_state: bool) -> None:
            raise NotImplementedError("true poses aren't sampled")

    return TrueRelation
