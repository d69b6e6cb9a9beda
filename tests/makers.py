"""Shipped robots whose URDFs are in packages that may not be installed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.description.robot_names import SHIPPED_FOLDER, named_robots
from handcart.backends.urdf.packages import package_folders

PACKAGE = re.compile(r"package://([\w-]+)/")


def packages_of(file: Path) -> list[str]:
    """Names of the packages that a robot's file names."""
    return sorted(set(PACKAGE.findall(file.read_text(encoding="utf-8"))))


def missing_package(file: Path) -> str:
    """Name of a package that isn't installed; "" for none."""
    return next((name for name in packages_of(file) if not any(package_folders(name))), "")


def every_robot(short: bool = False) -> list[Any]:
    """Parameters for a test of all robots; those without their package are skipped."""
    found = []
    for name, path in named_robots().items():
        if short and "/" in name:
            continue
        missing = missing_package(path)
        skip = pytest.mark.skipif(bool(missing), reason=f"the package {missing} is not installed")
        found.append(pytest.param(name, marks=skip))
    return found


def makers_robots() -> dict[str, Path]:
    """Shipped robots with a URDF from a package other than PyBullet's data."""
    return {
        name: path
        for name, path in named_robots().items()
        if path.is_relative_to(SHIPPED_FOLDER) and set(packages_of(path)) - {"pybullet_data"}
    }
