"""The keys that every entry under `actions:` has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from handcart.files.models.model import FileModel
from handcart.networks.graph.network import MAX_ATTEMPTS, MAX_COST_S

Probability = Annotated[float, Field(ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)] | Literal["unlimited"]

OTHER_CAUSES = "else"
"""Key for the causes that are not named."""


class AttemptsEntry(FileModel):
    """Keys of a task file that limit the Fails of an action, after which the action is excluded."""

    most: Count = 3
    """Maximum number of Fails, or `unlimited`."""
    budget: str | None = None
    """Name of one of the task's `budgets`, shared with all actions that name it."""
    shared: bool = False
    """True if the copies of the action in a repeat share its attempts."""
    fresh_after: str | list[str] = Field(default_factory=list)
    """Primitives after whose Success the Fails are forgotten, in a repeat for the same element."""
    renewals: Annotated[int, Field(ge=1, le=MAX_ATTEMPTS)] = 3
    """Maximum number of times that the Fails are forgotten."""


class EndingChance(FileModel):
    """Keys in a task file for one of several results of a Success, with the result's probability."""

    p: Probability | None = None
    """Probability that an attempt ends so."""
    result: str = ""
    """Result by which the primitive reports it (default: the usual one)."""


class FailChance(FileModel):
    """Entry of a task file for Fails of an action by one cause, with their probability."""

    p: Probability | None = None
    """Probability that an attempt fails so."""


class TaskEntry(FileModel):
    """Keys of an action in a task file apart from its situations, such as primitive, cost and attempts."""

    do: str
    """Name of the primitive."""
    cost_s: Annotated[float, Field(gt=0.0, le=MAX_COST_S)]
    """Expected duration; each Fail doubles its weight in planning."""
    route_from: str | None = None
    """Fact whose value, where the action starts, is the name of the base's place: the driving time of the
    planned route from there to the action's place is added to `cost_s`.
    """
    attempts: Count | AttemptsEntry = 3
    """Maximum number of Fails, after which the action is excluded; or how they are counted."""
    p: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    """Probability that an attempt ends in Success; `handcart check` then reports how runs end."""
    p_give_up: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    """Probability that an attempt ends in GiveUp; the rest is the probability of Fail."""
    permit: Literal["operator", "none"] | None = None
    """`operator`: it starts only when the operator permits it, each time; `none`: it doesn't ask (default: as
    its primitive says).
    """
    time_out_s: Annotated[float, Field(gt=0.0, le=MAX_COST_S)] | None = None
    """Time limit of the motion; after that it is stopped, restored, and counts as a Fail."""
    parameters: Annotated[dict[str, Any], Field(alias="with", default_factory=dict)]
    """The primitive's parameters; `{model: cup.size}` is looked up when the action starts, `{each: slot}`
    is the element of a repeat."""

    if TYPE_CHECKING:  # fields or properties, which each kind of entry has

        @property
        def source(self) -> str:
            """The situation in which it starts, or its conditions in words."""
            ...

        @property
        def target(self) -> str:
            """The usual situation after Success, or the usual effect in words."""
            ...

        @property
        def is_plain(self) -> bool:
            """True if Success has one effect, whose probability is `p`."""
            ...

        @property
        def p_success(self) -> float | None:
            """Probability of Success, whatever its effect; None: not given."""
            ...

        @property
        def endings(self) -> Sequence[EndingChance]:
            """The effects that Success may have, the usual one first."""
            ...

        @property
        def fail_entries(self) -> Mapping[str, FailChance]:
            """Effects of Fails of named causes."""
            ...

    @cached_property
    def limit(self) -> AttemptsEntry:
        """Limit on the number of the action's Fails.

        If the entry's key `attempts` is only a number, it is the maximum, and the count is never reset by the
        Success of another action.
        """
        if isinstance(self.attempts, AttemptsEntry):
            return self.attempts
        return AttemptsEntry.model_construct(
            most=self.attempts, budget=None, shared=False, fresh_after=[], renewals=3
        )


def listed_names(names: str | list[str] | None) -> tuple[str, ...]:
    """Return a name, or a list of names, as a tuple; None gives an empty one."""
    return (names,) if isinstance(names, str) else tuple(names or ())
