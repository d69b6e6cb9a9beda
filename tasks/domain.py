"""What a domain of tasks brings: books, blocks, sensors in a field, potted plants ..."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

OWN = ("books", "blocks", "field", "seam", "calibration")
"""Shipped domains, each declared in a module of its name in `handcart.tasks`."""


class Knowledge(NamedTuple):
    """What of a domain a robot is told, and learns."""

    section: str
    """A `handcart.primitives.knowledge.section:Section`."""
    files: Mapping[str, str] = MappingProxyType({})
    """Keys under `knowledge:` of a task file that name its files, each with what the file holds, in words."""


@dataclass(frozen=True, eq=False)
class Domain:
    """All parts of a domain, each by the import path "module:name" of what is imported when it is needed.

    A package of somebody else names its own by an entry point of the group `handcart.domains`.
    """

    name: str
    primitives: Mapping[str, str] = field(default_factory=dict)
    """By the name that task files use."""
    knowledge: Knowledge | None = None
    props: str | None = None
    """A `handcart.backends.scene.props:Props`: what of the domain stands in simulated worlds."""
    physics: Mapping[str, str] = field(default_factory=dict)
    """By a backend's name: the bodies of its props there, by the class of a thing or of the props."""
    survey: str | None = None
    """A `handcart.evaluation.survey:Survey`: what ground truth says of the domain's outcomes."""
    faults: str | None = None
    """A sequence of `handcart.evaluation.conformance.fault:Fault`: what may happen in a simulated world to
    what the domain's primitives work on. The conformance kit injects them into these primitives."""
    files: Mapping[str, str] = field(default_factory=dict)
    """Models of its kinds of file, by what stands behind `handcart-` under their key `format`."""
    rehearsals: Mapping[Path, Mapping[str, str]] = field(default_factory=dict)
    """Task files that the conformance kit runs, and in whose actions it injects faults: for that with these
    settings, so that an action of each kind is enough. The robot that a file names is tried in it."""


def imported(path: str) -> Any:
    """What an import path "module:name" stands for."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


@cache
def domains() -> tuple[Domain, ...]:
    """All domains, the shipped ones first, then those of other packages by their names.

    Raises:
        ValueError: two have the same name.
    """
    own = [imported(f"handcart.tasks.{name}:DOMAIN") for name in OWN]
    others = [each.load() for each in sorted(entry_points(group="handcart.domains"), key=lambda e: e.name)]
    found = {each.name: each for each in own + others}
    if len(found) < len(own + others):
        raise ValueError(f"two domains have the same name; there are: {', '.join(found)}")
    return tuple(found.values())
