"""Every check of a backend, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from handcart.backends.sensors.sensor_kind import sensor_kinds
from handcart.tasks.domain import domains, imported

from . import (
    capability_checks,
    command_checks,
    geometry_checks,
    navigation_checks,
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
    navigation_checks,
)


@cache
def checks() -> Mapping[str, Check]:
    """Return all conformance checks of backends, by name.

    The general checks come first, then those of kinds of sensors, then those of application domains.
    """
    own = [check for module in CHECK_MODULES for check in module.CHECKS]
    own += [check for kind in sensor_kinds().values() if kind.checks for check in imported(kind.checks)]
    others = [check for domain in domains() if domain.checks for check in imported(domain.checks)]
    return MappingProxyType({check.name: check for check in (*own, *others)})
