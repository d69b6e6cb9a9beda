"""What a domain of tasks brings: books, blocks, sensors in a field, potted plants ..."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from handcart.files.errors import InputError
from handcart.files.plugins import entry_points_of, error_words, package_of
from handcart.files.printable import printable

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

OWN = ("books", "blocks", "field", "seam", "calibration")
"""Shipped domains, each declared in a module of its name in `handcart.tasks`."""


class BrokenDomain(InputError):
    """A domain of another package can't be used."""

    def __init__(self, point: EntryPoint, wrong: str) -> None:
        package = package_of(point)
        how = "allowed: to mend the package, or to uninstall it"
        super().__init__(printable(f"the domain {point.name!r}{package} can't be used: {wrong}; {how}"))


class Knowledge(NamedTuple):
    """What of a domain a robot is told, and learns."""

    section: str
    """A `handcart.primitives.knowledge.section:Section`."""
    files: Mapping[str, str] = MappingProxyType({})
    """Keys under `knowledge:` of a task file that name its files, each with what the file holds, in words."""


class Command(NamedTuple):
    """A command of `handcart` that belongs to a domain."""

    function: str
    """What typer makes a command of."""
    help: str


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
    """A `handcart.backends.simulation.props:Props`: what of the domain stands in simulated worlds."""
    physics: str | None = None
    """A mapping: the bodies of its props in physics, whatever the engine, by the class of a thing or of the
    props."""
    survey: str | None = None
    """A `handcart.evaluation.truth.survey:Survey`: what ground truth says of the domain's outcomes."""
    faults: str | None = None
    """A sequence of `handcart.evaluation.conformance.faults.fault:Fault`: what may happen in a simulated
    world to what the domain's primitives work on. The conformance kit injects them into these primitives."""
    files: Mapping[str, str] = field(default_factory=dict)
    """Models of its kinds of file, by what stands behind `handcart-` under their key `format`."""
    checks: str | None = None
    """A sequence of `handcart.evaluation.conformance.checks.check:Check`: what must hold of every backend
    that shows the domain's things. The conformance kit makes them with its own."""
    worlds: Mapping[str, str] = field(default_factory=dict)
    """By name, what makes a `handcart.evaluation.campaigns.campaign_setting:WorldGenerator` of its options,
    given as keyword arguments: `handcart campaign --generate NAME.KEY=VALUE`."""
    commands: Mapping[str, Command] = field(default_factory=dict)
    """Commands of `handcart`, by name."""
    task_facts: str | None = None
    """A function from a `handcart.networks.task.task_file:Task` to figures by name: what `handcart check`
    tells of a task; it may take seconds, and raise FileError."""
    robot_facts: str | None = None
    """A function from a robot's file, and what its hand reaches or None, to a
    `handcart.evaluation.robot_report.domain_facts:DomainFacts`: what `handcart check` tells of a robot."""
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
        BrokenDomain: one of another package can't be imported, is none, or has another one's name.
    """
    found: dict[str, Domain] = {name: imported(f"handcart.tasks.{name}:DOMAIN") for name in OWN}
    for point in entry_points_of("handcart.domains"):
        domain = _loaded(point)
        if domain.name in found:
            raise BrokenDomain(point, f"there is another domain of the name {domain.name!r}")
        if both := _names(domain) & {name for each in found.values() for name in _names(each)}:
            raise BrokenDomain(point, f"another domain has {', '.join(sorted(both))} already")
        found[domain.name] = domain
    return tuple(found.values())


def _names(domain: Domain) -> set[str]:
    """What only one domain can have."""
    keys = domain.knowledge.files if domain.knowledge else ()
    kinds = {
        "the primitive": domain.primitives,
        "the key": keys,
        "the kind of file": domain.files,
        "worlds called": domain.worlds,
        "the command": domain.commands,
    }
    return {f"{kind} {name}" for kind, names in kinds.items() for name in names}


def _loaded(point: EntryPoint) -> Domain:
    try:
        domain = point.load()
    except (Exception, SystemExit) as error:
        raise BrokenDomain(point, error_words(error)) from None
    if not isinstance(domain, Domain):
        raise BrokenDomain(point, f"{point.value} is no Domain")
    return domain
