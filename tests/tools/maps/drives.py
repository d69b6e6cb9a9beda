"""A small drive with a loop, as a log."""

from __future__ import annotations

from functools import cache

from benchmarks.driving.worlds.mapped_floor import Drive, Floor, drive, make_floor


@cache
def small_floor() -> Floor:
    """A floor around one block."""
    return make_floor(3, (1, 1), 35.0)


@cache
def small_drive() -> Drive:
    """A drive of about 45 m around the block; of each scan every third beam, and half of the scans."""
    found = drive(small_floor(), 3)
    log = found.log
    thinned = log._replace(
        times=log.times[::2], odometry=log.odometry[::2], angles=log.angles[::3], ranges=log.ranges[::2, ::3]
    )
    return Drive(thinned, found.truth[::2])
