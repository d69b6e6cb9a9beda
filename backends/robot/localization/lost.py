"""Reason why the pose of a base is unknown."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.navigation.locating.scan_jump import MAX_CHANGED_SHARE

MAX_STALE_S = 10.0  # of scans that repeat while the base moved, until its pose counts as unknown
LIFTED_REASON = "it was lifted and set down elsewhere: its scans changed at once, and its wheels did not turn"


class Lost(NamedTuple):
    """Reason why the base's pose is unknown, with the measured quantity that exceeded its limit."""

    why: str
    """Reason, as text."""
    sensor: str
    """Capability that no longer determines the pose."""
    what: str
    """Name of the quantity that showed that the pose is unknown."""
    value: float
    limit: float
    unit: str = ""


def lost_by_stale_lidar(seconds: float) -> Lost | None:
    """Return the reason for an unknown pose if the lidar repeats its last scan for over 10 s, otherwise None.

    Args:
        seconds: time since the lidar's last new scan while the base moved, in [s].
    """
    if seconds <= MAX_STALE_S:
        return None
    what = "time since the last new scan"
    return Lost("its lidar repeats its last scan", "RangeSensor", what, seconds, MAX_STALE_S, "s")


def lifted_by(share: float) -> Lost:
    """Return the reason "lifted" for an unknown pose; `share` (0 to 1) of the beams changed from scan to
    scan.
    """
    what = "share of beams that changed at once"
    return Lost(LIFTED_REASON, "RangeSensor", what, share, MAX_CHANGED_SHARE)
