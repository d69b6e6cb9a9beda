"""Domains of tasks, such as books, blocks, sensors in a field or potted plants."""

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

SHIPPED_DOMAINS = ("books", "blocks", "field", "seam", "calibration", "objects", "doors", "activities")
"""Shipped domains, each declared in a module of its name in `handcart.tasks`."""


class BrokenDomain(InputError):
    """Error for a domain of another package that can't be imported or used."""

    def __init__(self, point: EntryPoint, wrong: str) -> None:
        package = package_of(point)
        how = "allowed: to mend the package, or to uninstall it"
        super().__init__(printable(f"the domain {point.name!r}{package} can't be used: {wrong}; {how}"))


class Knowledge(NamedTuple):
    """Declaration of a domain's section of the world model: its class, and the keys of its files in task
    files.
    """

    section: str
    """Import path of a subclass of `handcart.primitives.knowledge.section:Section`."""
    files: Mapping[str, str] = MappingProxyType({})
    """Keys under `knowledge:` of a task file that name its files, each with what the file holds, in words."""


class Command(NamedTuple):
    """Subcommand of the command line program `handcart` that a domain adds, with its help text."""

    function: str
    """Import path of the function that typer makes a command of."""
    help: str


@dataclass(frozen=True, eq=False)
class Domain:
    """Declaration of a domain, which is a kind of work such as handling books, with its primitives, file
    formats and other parts.

    Each part is given by an import path "module:name", so that it is imported only when needed.
    """

    name: str
    primitives: Mapping[str, str] = field(default_factory=dict)
    """Primitives by the name in task files."""
    knowledge: Knowledge | None = None
    props: str | None = None
    """A subclass of `handcart.backends.simulation.world.props:Props`: the domain's objects in simulated
    worlds.
    """
    physics: str | None = None
    """A mapping: the bodies of its props in physics, whatever the engine, by the class of a thing or of the
    props."""
    survey: str | None = None
    """A subclass of `handcart.evaluation.judging.survey:Survey`: ground truth of the domain's outcomes."""
    faults: str | None = None
    """A sequence of `handcart.evaluation.conformance.faults.fault:Fault`: faults of the domain's objects in a
    simulated world. The conformance kit injects them into the domain's primitives.
    """
    files: Mapping[str, str] = field(default_factory=dict)
    """Models of its kinds of file, by the part of their key `format` after `handcart-`."""
    checks: str | None = None
    """A sequence of `handcart.evaluation.conformance.checks.check:Check`: requirements for every backend that
    shows the domain's objects. The conformance kit runs them with its own.
    """
    mutants: str | None = None
    """A sequence of `handcart.evaluation.conformance.planted.mutant:Mutant`: faulty primitives of the domain,
    which the conformance kit has to find.
    """
    worlds: Mapping[str, str] = field(default_factory=dict)
    """Functions by name that make a `handcart.evaluation.campaigns.campaign_setting:WorldGenerator` of their
    keyword arguments, the options of `handcart campaign --generate NAME.KEY=VALUE`.
    """
    commands: Mapping[str, Command] = field(default_factory=dict)
    """Commands of `handcart`, by name."""
    task_facts: str | None = None
    """A function from a `handcart.networks.task.task_file:Task` to figures by name, which `handcart check`
    reports for a task; it may take seconds, and raise FileError.
    """
    robot_facts: str | None = None
    """A function from a robot's file, and the reach of its hand or None, to a
    `handcart.evaluation.robot_report.domain_facts:DomainFacts`, which `handcart check` reports for a
    robot.
    """
    rehearsals: Mapping[Path, Mapping[str, str]] = field(default_factory=dict)
    """Task files that the conformance kit runs and injects faults into, with settings that make one action of
    each kind enough. A file serves the robot that it names.
    """


def imported(path: str) -> Any:
    """Return the object at an import path "module:name"."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


@cache
def domains() -> tuple[Domain, ...]:
    """Return all domains, the shipped ones first, then those of other packages by their names.

    Raises:
        BrokenDomain: a domain of another package cannot be imported, is not a `Domain`, or has the name of
            another domain.
    """
    found: dict[str, Domain] = {name: imported(f"handcart.tasks.{name}:DOMAIN") for name in SHIPPED_DOMAINS}
    for point in entry_points_of("handcart.domains"):
        domain = _loaded(point)
        if domain.name in found:
            raise BrokenDomain(point, f"there is another domain of the name {domain.name!r}")
        if both := _names(domain) & {name for domain_ in found.values() for name in _names(domain_)}:
            raise BrokenDomain(point, f"another domain has {', '.join(sorted(both))} already")
        found[domain.name] = domain
    return tuple(found.values())


def _names(domain: Domain) -> set[str]:
    """Return the names of a domain that no other domain may have, such as those of its primitives."""
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
