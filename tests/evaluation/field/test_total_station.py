"""Sight of a total station to the robot's reflector."""

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.simulation.field.spec import StationSpec
from handcart.evaluation.field.total_station import REFLECTOR_HEIGHT_M, TotalStation
from handcart.networks.task.preparing import prepare

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"
CRATE = "surprises: [{{name: crate, x_m: {}, y_m: {}, size_m: [0.6, 0.6, 2.0]}}]\n"


def sights(tmp_path: Path, side: float, crate: tuple[float, float] = (50.0, 50.0)) -> TotalStation:
    """Return the sights of a station 8 m to that side (+1 left, -1 right) of a robot at the origin, after
    three seconds.
    """
    world = tmp_path / "world.yaml"
    words = "format: handcart-world/1\nstart: {x_m: 0.0, y_m: 0.0}\nground: {}\nsensors: {count: 1}\n"
    world.write_text(words + CRATE.format(*crate), encoding="utf-8")
    with prepare(TASK, "kinematic", {"world": str(world)}, 0) as prepared:
        scene = prepared.backend.scene  # type: ignore[attr-defined]
        station = TotalStation(StationSpec(x_m=0.0, y_m=8.0 * side), scene, seed=1)
        for _ in range(120):
            prepared.robot.step()
            station.look()
        hand = scene.world_T("hand")
        station_sees = np.array([sight.place for sight in station.sights]).reshape(-1, 3)
        off = station_sees - (hand[:3, 3] - REFLECTOR_HEIGHT_M * hand[:3, 0])
        assert np.abs(off).max(initial=0.0) < 5.0 * station.sigma
    return station


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_reflector_in_the_open_is_seen(tmp_path: Path, side: float) -> None:
    station = sights(tmp_path, side)
    assert len(station.sights) + station.hidden == 10
    assert station.hidden == 0


def test_what_stands_between_hides_it(tmp_path: Path) -> None:
    assert sights(tmp_path, 1.0, crate=(0.0, 7.0)).hidden == 10
    assert sights(tmp_path, 1.0, crate=(3.0, 7.0)).hidden == 0
    assert sights(tmp_path, 1.0, crate=(0.0, -7.0)).hidden == 0
    assert sights(tmp_path, 1.0, crate=(0.0, 9.5)).hidden == 0  # on the line of sight, behind the station
