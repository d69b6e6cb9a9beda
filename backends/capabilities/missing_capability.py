"""Error for a capability that a robot lacks."""

from __future__ import annotations

from collections.abc import Iterable

from handcart.files.errors import HandcartError

from .capability import Capability


class MissingCapability(HandcartError, ValueError):
    """Error: the robot lacks a capability that is asked for."""

    exit_status = 2

    def __init__(self, kind: type[Capability], there: Iterable[Capability], needed_by: str = "") -> None:
        have = ", ".join(sorted(_name(type(capability)) for capability in there))
        reason = f", which {needed_by} needs" if needed_by else ""
        super().__init__(f"the robot has no {kind.__name__}{reason}; it has: {have}")


def _name(kind: type) -> str:
    return next(item.__name__ for item in kind.__mro__ if Capability in item.__bases__)
