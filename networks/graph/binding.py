"""A primitive with its parameters, some of them known only when the action starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pydantic import ValidationError

from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.knowledge.world_model import UnknownFact, WorldModel


class NotBound(Exception):
    """A late-bound parameter has no fitting value now; the action counts as failed before it starts."""


@dataclass(frozen=True)
class Binding:
    """A kind of primitive with fixed parameters and those that come from the world model."""

    kind: type[ActionPrimitive]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    """Checked values, by parameter."""
    late: Mapping[str, str] = field(default_factory=dict)
    """Names in the world model, such as `cup.size`, by parameter."""

    @classmethod
    def of(cls, primitive: ActionPrimitive) -> Binding:
        """A primitive all of whose parameters are known."""
        return cls(type(primitive), {name: getattr(primitive, name) for name in type(primitive).model_fields})

    @cached_property
    def label(self) -> str:
        """The primitive's name in files."""
        return self.kind.label()

    def make(self, model: WorldModel) -> ActionPrimitive:
        """A fresh instance, for one attempt, with all its parameters.

        Raises:
            NotBound: the world model doesn't know a value yet, or it is none that the parameter takes.
        """
        if not self.late:
            return self.kind.model_validate(self.fixed)
        try:
            known = {name: model.lookup(key) for name, key in self.late.items()}
            return self.kind.model_validate({**self.fixed, **known})
        except UnknownFact as unknown:
            raise NotBound(str(unknown)) from None
        except ValidationError as error:
            wrong = error.errors(include_url=False)[0]
            raise NotBound(f"{'.'.join(map(str, wrong['loc']))}: {wrong['msg']}") from None

    def said(self) -> dict[str, Any]:
        """The parameters as they would stand in a file."""
        late = {name: {"model": key} for name, key in self.late.items()}
        if not self.fixed:
            return late
        dumped = self.kind.model_construct(**self.fixed).model_dump(mode="json", include=set(self.fixed))
        return {**dumped, **late}
