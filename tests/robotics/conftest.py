"""The librarian's arm."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.robotics.kinematics.arm_model import ArmModel

ROBOT = Path(__file__).resolve().parents[2] / "backends" / "robots" / "librarian" / "librarian.urdf"


@pytest.fixture(scope="session")
def urdf() -> str:
    return ROBOT.read_text()


@pytest.fixture(scope="session")
def arm(urdf: str) -> ArmModel:
    return ArmModel(urdf, [f"joint_{number}" for number in range(1, 7)])
