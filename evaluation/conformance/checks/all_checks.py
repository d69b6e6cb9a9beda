"""Every check of a backend, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from handcart.tasks.domain import domains, imported

from . import (
    beacon_checks,
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

CHECK_MODULES = (
    capability_checks,
    command_checks,
    time_checks,
    snapshot_checks,
    geometry_checks,
    positioning_checks,
    imu_checks,
    gps_checks,
    beacon_checks,
)


@cache
def checks() -> Mapping[str, Check]:
    """The framework's, then those of the domains."""
    own = [check for module in CHECK_MODULES for check in module.CHECKS]
    others = [check for domain in domains() if domain.checks for check in imported(domain.checks)]
    return MappingProxyType({check.name: check for check in (*own, *others)})
