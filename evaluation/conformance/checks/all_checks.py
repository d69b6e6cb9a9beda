"""Every check of a backend, by name."""

from __future__ import annotations

from collections.abc import Mapping

from . import (
    capability_checks,
    command_checks,
    geometry_checks,
    gps_checks,
    imu_checks,
    positioning_checks,
    snapshot_checks,
    time_checks,
)
from .check import Check

MODULES = (
    capability_checks,
    command_checks,
    time_checks,
    snapshot_checks,
    geometry_checks,
    positioning_checks,
    imu_checks,
    gps_checks,
)
CHECKS: Mapping[str, Check] = {check.name: check for module in MODULES for check in module.CHECKS}
