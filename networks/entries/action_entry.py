"""Entries of a network that is written in the task's file, situation by situation."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Self

from pydantic import Field, model_validator

from .entry import OTHER_CAUSES, EndingChance, FailChance, TaskEntry


class ThenEntry(EndingChance):
    """Entry of an action's `then` in a task file, for one of several situations that Success may lead to."""

    target: Annotated[str, Field(alias="to")]
    """The situation."""


class FailEntry(FailChance):
    """Entry of an action's `on_fail` in a task file, for Fails of one cause."""

    to: str | None = None
    """The situation: same facts, other knowledge (default: it remains as it is)."""


class ActionEntry(TaskEntry):
    """Entry of an action in a task file that names the situations before and after the action."""

    source: Annotated[str, Field(alias="from")]
    """The situation in which it can be done."""
    to: str = ""
    """The situation that Success leads to; `then` if there are several."""
    then: Annotated[list[ThenEntry], Field(min_length=1)] | None = None
    """The situations that Success may lead to, the usual one first."""
    fails: Annotated[str | dict[str, str | FailEntry] | None, Field(alias="on_fail")] = None
    """The situation that Fail leads to: same facts, other knowledge (default: Fail changes nothing); or one
    for each cause, and `else`.
    """

    @model_validator(mode="after")
    def _leads_somewhere(self) -> Self:
        if self.then is None and not self.to:
            raise ValueError("the key 'to' is missing; needed: the situation that Success leads to")
        if self.then is not None and self.to:
            raise ValueError("has both `to` and `then`; allowed: one of them")
        if self.then is not None and self.p is not None:
            raise ValueError("has both `p` and `then`; allowed: p in each entry of `then`")
        return self

    @property
    def target(self) -> str:
        """The situation that Success leads to; the first one if there are several."""
        return self.then[0].target if self.then else self.to

    @cached_property
    def endings(self) -> list[ThenEntry]:
        """All situations that Success may lead to, each with its probability, in the order of the file."""
        return self.then or [ThenEntry.model_construct(target=self.to, p=self.p, result="")]

    @property
    def leads_to(self) -> list[str]:
        """All situations that the action may lead to, first those after Success, then those after Fail."""
        return [*(ending.target for ending in self.endings), *self.fail_situations]

    @property
    def on_fail(self) -> str | None:
        """Situation to which a Fail leads if its cause is not named in the file; None if the situation does
        not change.
        """
        if isinstance(self.fails, str):
            return self.fails
        named = self._by_cause.get(OTHER_CAUSES)
        return None if named is None else named.to

    @property
    def fail_entries(self) -> dict[str, FailEntry]:
        """Entries of `on_fail` for Fails of named causes, by the cause's name."""
        return {cause: entry for cause, entry in self._by_cause.items() if cause != OTHER_CAUSES}

    @property
    def fail_situations(self) -> list[str]:
        """All situations that a Fail may lead to: first those of the causes that have an entry in the file,
        then that of all other causes, if the file names one.
        """
        return [to for to in (*(e.to for e in self.fail_entries.values()), self.on_fail) if to]

    @property
    def _by_cause(self) -> dict[str, FailEntry]:
        if not isinstance(self.fails, dict):
            return {}
        return {
            cause: FailEntry(to=fail) if isinstance(fail, str) else fail for cause, fail in self.fails.items()
        }

    @property
    def p_success(self) -> float | None:
        """Probability that the action ends in Success, in whichever situation; None if the file does not give
        it.
        """
        every = [ending.p for ending in self.endings]
        return None if None in every else sum(p or 0.0 for p in every)

    @property
    def is_plain(self) -> bool:
        """True if Success always leads to the same situation; `p` is then the probability of Success."""
        return self.then is None
