"""The sections that domains declare."""

from __future__ import annotations

from functools import cache
from typing import Any, cast

from handcart.tasks.domain import Domain, domains, imported

from .section import Section


@cache
def section_class(domain: Domain) -> type[Section] | None:
    """Import and return the class of a domain's world model section; None if the domain has no section."""
    found: type[Section] | None = imported(domain.knowledge.section) if domain.knowledge else None
    return found


def sections() -> dict[str, type[Section]]:
    """Return the classes of all world model sections, by the names of their domains (kinds of work)."""
    found = {domain.name: section_class(domain) for domain in domains()}
    return {name: kind for name, kind in found.items() if kind is not None}


def name_of(kind: type[Section]) -> str:
    """Return the name of the domain (kind of work) to which a class of world model sections belongs."""
    return _name_of(cast(Any, kind))


@cache
def _name_of(kind: Any) -> str:
    for name, section in sections().items():
        if section is kind:
            return name
    raise LookupError(f"no domain declares the section {kind.__name__}")
