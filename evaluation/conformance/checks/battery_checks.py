"""Checks of batteries."""

from __future__ import annotations

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.battery import Battery
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import drivable

from .check import Check, CheckResult

PERIOD_COUNT = 60
DRIVE_SPEED_M_S = 0.2
MAX_CHANGE_PERCENT = 20.0
"""Maximum change during the check of a reading that is a charge."""


def battery(bench: KitBench, finding: CheckResult) -> None:
    """Check that the battery's charge is 0 to 100 %, is constant within a period, and changes by at most
    `MAX_CHANGE_PERCENT` in `PERIOD_COUNT` periods of driving.
    """
    with bench.rig() as rig:
        backend, cell = rig.backend, needed(rig.backend, Battery)
        base, read = needed(backend, Base), list[float]()
        for _ in range(PERIOD_COUNT):
            base.drive(*drivable(bench.spec(), DRIVE_SPEED_M_S, 0.0))
            backend.step()
            read.append(cell.charge_percent())
            finding.expect(cell.charge_percent() == read[-1], "a second reading in a period differs")
            finding.expect(0.0 <= read[-1] <= 100.0, f"charge {read[-1]:g} %")
        finding.at_most("changed", max(read) - min(read), MAX_CHANGE_PERCENT, "%")


CHECKS = (Check("battery", "its charge is a percentage that changes slowly", battery),)
