"""Reason why the pose of a base is unknown."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.navigation.locating.scan_jump import MAX_CHANGED_SHARE

LIFTED_REASON = "it was lifted and set down elsewhere: its scans changed at once, and its wheels did not turn"


class Lost(NamedTuple):
    """Reason why the base's pose is unknown."""

    why: str
    """Reason, as text."""
    sensor: str
    """Capability that no longer determines the pose."""
    what: str
    """Name of the deciding quantity."""
    value: float
    limit: float
    unit: str = ""


def lifted_by(share: float) -> Lost:
    """Return that the base was lifted, by the share of beams that changed at once."""
    what = "share of beams that changed at once"
    return Lost(LIFTED_REASON, "RangeSensor", what, share, MAX_CHANGED_SHARE)
