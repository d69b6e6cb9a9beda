"""A base that cannot balance is named as it tips."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend

WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.0}
walls:
  - {from_m: [0, 0], to_m: [8, 0]}
"""


@pytest.mark.parametrize("casters", [True, False])
def test_a_base_without_casters_is_said_to_tip(tmp_path: Path, casters: bool) -> None:
    for file in robot_path("cart").parent.glob("*.*"):
        shutil.copy(file, tmp_path)
    urdf, world = tmp_path / "cart.urdf", tmp_path / "world.yaml"
    if not casters:
        urdf.write_text(
            urdf.read_text(encoding="utf-8").replace("0.27 0 0.03", "0.27 0 0.1"), encoding="utf-8"
        )
    world.write_text(WORLD, encoding="utf-8")
    backend = make_backend("mujoco", load_robot(str(tmp_path / "robot.yaml")), world, 0)
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None

    def drive() -> None:
        for speed in (0.6, 0.0):
            for _ in range(40):
                base.drive(speed, 0.0)
                backend.step()

    if casters:
        drive()
    else:
        with pytest.raises(RobotFault, match=r"the base has tipped, by .* degrees: what it stands on"):
            drive()
    backend.close()
