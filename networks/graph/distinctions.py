"""Distinctions between actions that do the same primitive between the same situations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

MAX_VALUE_LENGTH = 24
"""Longest value of a parameter that is shown, in characters."""


class SiblingAction(NamedTuple):
    """Data of an action that may distinguish it from its siblings: its parameters and its cost.

    Siblings are actions with the same primitive, between the same situations.
    """

    do: str
    source: str
    target: str
    given: Callable[[], Mapping[str, Any]]
    """Function that returns the parameters that are not at their defaults."""
    cost_s: float


def distinctions(actions: Sequence[SiblingAction | None]) -> dict[int, str]:
    """Return a text that distinguishes each action from actions with the same primitive and situations.

    The text has the parameters in which these actions differ, such as `looks: 8`, or the cost if no parameter
    differs.

    Args:
        actions: the actions; None (for a skip) is ignored.

    Returns:
        The text by the action's index in `actions`; actions that need none are missing.
    """
    alike: dict[tuple[str, ...], list[int]] = {}
    for place, action in enumerate(actions):
        if action is not None:
            alike.setdefault(action[:3], []).append(place)
    found: dict[int, str] = {}
    for places in alike.values():
        if len(places) > 1:
            words = _distinguished([each for place in places if (each := actions[place])])
            found |= zip(places, words, strict=True)
    return found


def _distinguished(actions: Sequence[SiblingAction]) -> list[str]:
    given = [action.given() for action in actions]
    differing = [name for name in dict.fromkeys(n for item in given for n in item) if _differs(name, given)]
    if not differing:
        return [f"cost_s: {action.cost_s:g}" for action in actions]
    return [
        ", ".join(f"{name}: {_shown(item[name])}" for name in differing if name in item) for item in given
    ]


def _differs(name: str, given: Sequence[Mapping[str, Any]]) -> bool:
    return any(name not in entry or entry[name] != given[0][name] for entry in given)


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    words = str(value)
    return words if len(words) <= MAX_VALUE_LENGTH else words[: MAX_VALUE_LENGTH - 3] + "..."
