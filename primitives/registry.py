"""The primitives that task files can name."""

from __future__ import annotations

from functools import cache

from handcart.files.plugins import check_name, import_plugin, paths_of
from handcart.files.suggest import suggest
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.tasks.domain import domains

PRIMITIVES_GROUP = "handcart.primitives"
GENERAL_PRIMITIVES = {
    "MOVE_TO": "handcart.primitives.driving.move_to:MoveTo",
    "EXPLORE": "handcart.primitives.driving.exploring.explore:Explore",
    "LOCATE": "handcart.primitives.driving.locate:Locate",
    "MODIFY": "handcart.primitives.driving.modify:Modify",
    "ORIENT": "handcart.primitives.driving.orient:Orient",
    "STAND": "handcart.primitives.driving.stand:Stand",
}
"""Primitives without a domain, by name; domains add theirs, and other packages by an entry point of the group
`handcart.primitives`.
"""


@cache
def _own() -> dict[str, str]:
    found = dict(GENERAL_PRIMITIVES)
    for domain in domains():
        found |= domain.primitives
    return found


@cache
def _all() -> dict[str, str]:
    return paths_of(PRIMITIVES_GROUP, _own())


def primitive_names() -> list[str]:
    """Return the names of all primitives, shipped ones and those of other packages."""
    return sorted(_all())


def primitive_class(name: str) -> type[ActionPrimitive]:
    """Return the class of a primitive by its name.

    Raises:
        KeyError: no primitive has that name; the message lists those that exist.
        BrokenPlugin: another package's primitive cannot be imported, or has the name of another one.
    """
    if name not in _all():
        raise KeyError(f"unknown primitive {name!r}{suggest(name, primitive_names())}")
    check_name(name, PRIMITIVES_GROUP, _own())
    found: type[ActionPrimitive] = import_plugin(_all()[name], f"the primitive {name!r}")
    return found
