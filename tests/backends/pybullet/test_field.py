"""Laying sensors in physics: a height field, wheels that touch it, sensors that stand on it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from backends.ground_spec import GroundSpec
from evaluation.running import resume_task, run_task
from networks.events import Ended, Event

pytest.importorskip("pybullet")

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"


class Copier:
    """Copies a run's folder when an action has ended: what would be left if it were killed then."""

    def __init__(self, number: int, to: Path) -> None:
        self.number, self.to, self.folder = number, to, Path()

    def say(self, words: str) -> None:
        pass

    def begin(self, prepared: object, folder: Path) -> None:
        self.folder = folder

    def look(self, robot: object) -> None:
        pass

    def __call__(self, event: Event) -> None:
        if isinstance(event, Ended) and event.number == self.number:
            shutil.copytree(self.folder, self.to, ignore=shutil.ignore_patterns("control"))


def test_a_sensor_is_laid_and_a_killed_run_goes_on(tmp_path):
    (tmp_path / "one.csv").write_text("name,x_m,y_m\nonly,4,-0.75\n", encoding="utf-8")
    settings = {"targets": str(tmp_path / "one.csv"), "wait_s": "5", "together": "true"}
    left = tmp_path / "left"
    whole, status = run_task(
        TASK, tmp_path, "pybullet", settings, seed=2, checkpoints=True, told=Copier(2, left)
    )
    assert status == 0
    metrics = whole["metrics"]
    assert metrics["untrue"] == []
    assert metrics["placed"] == 1
    assert metrics["error_mm_max"] < 600.0
    again, status = resume_task(left, None, Copier(0, left))
    assert status == 0
    ((first,), (second,)) = (each["metrics"]["placements"] for each in (whole, again))
    assert abs(first["true_x_mm"] - second["true_x_mm"]) < 30.0
    assert abs(first["true_y_mm"] - second["true_y_mm"]) < 30.0


def test_the_ground_is_as_rough_as_the_world_says():
    from backends.pybullet.physics import Physics
    from backends.pybullet.terrain import Terrain

    physics = Physics(0.025)
    try:
        terrain = Terrain(physics, GroundSpec(roughness_deg=2.0), 1)
        x, y = np.random.default_rng(0).uniform(-50.0, 50.0, (2, 4000))
        corners = [terrain.height(x + along, y + across) for along in (0.0, 0.6) for across in (-0.3, 0.3)]
        pitch = (corners[2] + corners[3] - corners[0] - corners[1]) / 1.2
        roll = (corners[1] + corners[3] - corners[0] - corners[2]) / 1.2
        assert np.degrees(pitch).std() == pytest.approx(2.0, abs=0.4)
        assert np.degrees(roll).std() == pytest.approx(2.0, abs=0.4)
        for tile in terrain.reach(1.0, 2.0):
            terrain.add(tile)
        for x, y in ((0.0, 0.0), (3.25, -1.5), (-4.0, 9.75)):
            hit = physics.p.rayTest((x, y, 1.0), (x, y, -1.0), physicsClientId=physics.client)[0]
            assert hit[3][2] == pytest.approx(float(terrain.height(np.array(x), np.array(y))), abs=2e-3)
    finally:
        physics.close()
