"""Discharge and charge of a simulated robot's battery."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.battery import Battery
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.simulation.sensors.simulated_battery import J_PER_WH

ROOT = Path(__file__).resolve().parents[4]
WORLD = """\
format: handcart-world/1
start: {x_m: 1.5, y_m: 1.5, heading_deg: 0}
walls:
  - {from_m: [0, 0], to_m: [9, 0]}
  - {from_m: [9, 0], to_m: [9, 3]}
  - {from_m: [9, 3], to_m: [0, 3]}
  - {from_m: [0, 3], to_m: [0, 0]}
"""
KEYS = "capacity_wh: 1, charge_percent: 50, idle_w: 20, drive_j_m: 200, turn_j_rad: 0, sigma_percent: 0"


def charges(folder: Path, keys: str, speed: float, seconds: float) -> tuple[float, float, float]:
    """Return the charge before and after driving in [%], and the distance in [m]."""
    text = (ROOT / "backends/robots/cart/robot.yaml").read_text(encoding="utf-8")
    (folder / "cart.urdf").write_bytes((ROOT / "backends/robots/cart/cart.urdf").read_bytes())
    (folder / "robot.yaml").write_text(f"{text}sensors:\n  battery: {{kind: battery, {keys}}}\n")
    (folder / "world.yaml").write_text(WORLD, encoding="utf-8")
    robot = load_robot(str(folder / "robot.yaml"))
    with make_backend("kinematic", robot, folder / "world.yaml", 1) as backend:
        cell, base = backend.get(Battery), backend.get(Base)  # type: ignore[type-abstract]
        assert cell is not None and base is not None
        before, began = cell.charge_percent(), backend.scene.base  # type: ignore[attr-defined]
        for _ in range(round(seconds / backend.period)):
            base.drive(speed, 0.0)
            backend.step()
        assert cell.charge_percent() == cell.charge_percent()
        moved = backend.scene.base.relative_to(began)  # type: ignore[attr-defined]
        return before, cell.charge_percent(), float(moved.x)


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_time_and_motion_discharge_a_battery(tmp_path: Path, speed: float) -> None:
    before, after, driven = charges(tmp_path, KEYS, speed, 6.0)
    used = 20.0 * 6.0 + 200.0 * driven
    assert before == 50.0
    assert after == pytest.approx(50.0 - 100.0 * used / J_PER_WH, abs=0.1)
    assert (driven > 2.0) is (speed > 0.0)


@pytest.mark.parametrize(("x", "charges_it"), [(1.5, True), (4.0, False)])
def test_chargers_charge_a_base_that_is_there(tmp_path: Path, x: float, charges_it: bool) -> None:
    keys = f"{KEYS}, charger: {{x_m: {x}, y_m: 1.5, power_w: 120}}"
    before, after, _ = charges(tmp_path, keys, 0.0, 6.0)
    power = 100.0 if charges_it else -20.0
    assert after - before == pytest.approx(100.0 * power * 6.0 / J_PER_WH, abs=0.1)
