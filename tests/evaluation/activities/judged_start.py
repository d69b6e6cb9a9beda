"""Verdict of BEHAVIOR-1K's evaluator on the initial conditions of an activity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from handcart.evaluation.activities.bddl_judge import scope_of, true_pose_backend
from handcart.evaluation.activities.definition import Definition
from handcart.evaluation.activities.true_relations import TrueThing


def start_holds(definition: Definition, things: Mapping[str, TrueThing]) -> bool:
    """Return whether the initial conditions hold for the true state of things, by their terms."""
    from bddl.condition_evaluation import compile_state, evaluate_state

    compiled = compile_state(
        [_nested(literal) for literal in definition.initial],
        true_pose_backend(),
        scope=scope_of(definition, things),
        object_map=definition.conditions.parsed_objects,
        generate_ground_options=False,
    )
    return bool(evaluate_state(compiled)[0])


def _nested(literal: tuple[str, ...]) -> list[Any]:
    return ["not", list(literal[1:])] if literal[0] == "not" else list(literal)
