"""The primitives that task files can name."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.metadata import entry_points

from handcart.files.suggest import suggest

from .action_primitive import ActionPrimitive

TABLE = {
    "RECOGNIZE": "handcart.primitives.recognize:Recognize",
    "PICK_UP": "handcart.primitives.pick_up:PickUp",
    "MOVE_TO": "handcart.primitives.move_to:MoveTo",
    "SEARCH": "handcart.primitives.search:Search",
    "APPROACH": "handcart.primitives.approach:Approach",
    "INSERT": "handcart.primitives.insert:Insert",
    "RELEASE": "handcart.primitives.release:Release",
    "MODIFY": "handcart.primitives.modify:Modify",
    "FIXATE": "handcart.primitives.fixate:Fixate",
    "PICK_UP_BLOCK": "handcart.primitives.pick_up_block:PickUpBlock",
    "STAND": "handcart.primitives.stand:Stand",
    "DEPLOY": "handcart.primitives.deploy:Deploy",
    "STACK": "handcart.primitives.stack:Stack",
    "DIVIDE": "handcart.primitives.divide:Divide",
    "TRACK": "handcart.primitives.track:Track",
    "CALIBRATE_SUSPENSION": "handcart.primitives.calibrate_suspension:CalibrateSuspension",
    "CALIBRATE_CAMERA": "handcart.primitives.calibrate_camera:CalibrateCamera",
}
"""Name to import path; other packages add theirs by an entry point of the group `handcart.primitives`."""


@cache
def _all() -> dict[str, str]:
    return TABLE | {each.name: each.value for each in entry_points(group="handcart.primitives")}


def primitive_names() -> list[str]:
    """All names, ours and those of other packages."""
    return sorted(_all())


def primitive_class(name: str) -> type[ActionPrimitive]:
    """The class of a name.

    Raises:
        KeyError: no primitive has that name; the message lists those that exist.
    """
    if name not in _all():
        raise KeyError(f"unknown primitive {name!r}{suggest(name, primitive_names())}")
    module, _, attribute = _all()[name].partition(":")
    found: type[ActionPrimitive] = getattr(import_module(module), attribute)
    return found
