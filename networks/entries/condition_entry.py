"""Entries of a network that is generated: the conditions under which an action starts, and its effects."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from handcart.networks.graph.network import Fact

from .entry import OTHER_CAUSES, EndingChance, FailChance, TaskEntry

Values = Annotated[list[Fact], Field(min_length=1, max_length=1000)]
"""Possible values of a fact."""
Conditions = dict[str, Fact | Values]
"""Value of each fact by its name; a list of values means any of them."""


class ConditionEnding(EndingChance):
    """One of several possible effects of a successful action, with the new values of facts and the
    probability of this effect.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Fact] = Field(init=False)

    @property
    def changes(self) -> Mapping[str, Fact]:
        """New values of the facts that change by this effect of a successful action, by the facts' names."""
        return self.__pydantic_extra__


class ConditionFail(FailChance):
    """Entry of an action's `on_fail` in a task file, with the facts that the robot knows after a Fail of one
    cause.
    """

    known: Annotated[dict[str, Fact], Field(default_factory=dict)]
    """Facts that the robot then knows (default: nothing new)."""


class ConditionEntry(TaskEntry):
    """Entry for an action in a task file that lists conditions instead of situations.

    The network generated from the file has this action in every situation in which the entry's conditions
    hold.
    """

    condition: Annotated[Conditions, Field(alias="if", default_factory=dict)]
    """Facts that have to hold; one that is not named may have any value."""
    then: dict[str, Fact] | Annotated[list[ConditionEnding], Field(min_length=1)]
    """Facts that hold after Success; a list if there are several possibilities, the usual one first."""
    fails: Annotated[dict[str, ConditionFail], Field(alias="on_fail", default_factory=dict)]
    """Facts that the robot knows after a Fail, by cause, and under `else`."""

    @model_validator(mode="after")
    def _has_one_p(self) -> Self:
        if self.p is not None and not self.is_plain:
            raise ValueError("has both `p` and a list in `then`; allowed: p in each entry of `then`")
        return self

    @property
    def is_plain(self) -> bool:
        """True if a Success of the action has a single possible effect, with the probability `p` of the
        action.
        """
        return isinstance(self.then, dict)

    @cached_property
    def endings(self) -> list[ConditionEnding]:
        """Effects that Success may have, in the order of the file."""
        if isinstance(self.then, dict):
            return [ConditionEnding.model_validate({**self.then, "p": self.p})]
        return self.then

    @property
    def source(self) -> str:
        """Conditions under which the action can be started, as text."""
        return facts_in_words(self.condition) or "anywhere"

    @property
    def target(self) -> str:
        """Changes of facts by a Success, as text; those of the first effect if it may have several."""
        return facts_in_words(self.endings[0].changes) or "the same"

    @property
    def on_fail(self) -> str | None:
        """Facts, as text, that the robot knows after a Fail whose cause the task file does not name; None
        without any.
        """
        return self._known_in_words(OTHER_CAUSES)

    @property
    def fail_entries(self) -> dict[str, ConditionFail]:
        """Facts that the robot knows after a Fail of the action, by cause, for each cause that the key
        `on_fail` names (not for `OTHER_CAUSES`).
        """
        return {cause: fail for cause, fail in self.fails.items() if cause != OTHER_CAUSES}

    @property
    def p_success(self) -> float | None:
        """Probability that the action ends in Success, whichever effects that has; None if the file does not
        state it.
        """
        every = [ending.p for ending in self.endings]
        return None if None in every else sum(p or 0.0 for p in every)

    def _known_in_words(self, cause: str) -> str | None:
        found = self.fails.get(cause)
        return facts_in_words(found.known) or None if found else None


def facts_in_words(facts: Mapping[str, object]) -> str:
    """Return names and values of facts on one line, such as "light on, loaded false"."""
    return ", ".join(f"{name} {value_in_words(value)}" for name, value in facts.items())


def value_in_words(value: object) -> str:
    """Return a fact's value as text, as in a situation's name; alternatives are joined by "|"."""
    if isinstance(value, list):
        return "|".join(map(value_in_words, value))
    return str(value).lower() if isinstance(value, bool) else str(value)
