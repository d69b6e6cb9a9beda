"""Every check of a backend, by name."""

from __future__ import annotations

from collections.abc import Mapping

from . import capability_checks, command_checks, geometry_checks, snapshot_checks, time_checks
from .check import Check

CHECKS: Mapping[str, Check] = {
    check.name: check
    for module in (capability_checks, command_checks, time_checks, snapshot_checks, geometry_checks)
    for check in module.CHECKS
}
