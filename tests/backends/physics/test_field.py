"""Laying sensors in physics: a height field, wheels that touch it, sensors that stand on it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.world.terrain import Terrain
from handcart.backends.simulation.world.world_model import world_model
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.evaluation.truth.survey import simulated_world
from handcart.networks.run_options import RunOptions
from handcart.networks.task.preparing import prepare

from ...conftest import Copier

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"


@pytest.mark.slow
def test_a_sensor_is_laid_and_a_killed_run_goes_on(
    physics: type[PhysicsBackend], tmp_path: Path, copier: type[Copier]
) -> None:
    (tmp_path / "one.csv").write_text("name,x_m,y_m\nonly,4,-0.75\n", encoding="utf-8")
    settings = {"targets": str(tmp_path / "one.csv"), "wait_s": "5", "together": "true"}
    left = tmp_path / "left"
    whole, status = run_task(
        TASK,
        tmp_path,
        RunOptions(
            backend=physics.name, settings=settings, seed=2, checkpoints=True, observers=(copier(2, left),)
        ),
    )
    assert status == 0
    metrics = whole["metrics"]
    assert metrics["untrue"] == []
    assert metrics["placed"] == 1
    assert metrics["error_mm_max"] < 600.0
    again, status = resume_task(left, None, RunOptions(observers=(copier(0, left),)))
    assert status == 0
    ((first,), (second,)) = (each["metrics"]["placements"] for each in (whole, again))
    assert abs(first["true_x_mm"] - second["true_x_mm"]) < 30.0
    assert abs(first["true_y_mm"] - second["true_y_mm"]) < 30.0


def test_a_car_stands_on_rough_ground(physics: type[PhysicsBackend]) -> None:
    with prepare(TASK, physics.name, seed=0) as prepared:
        scene = simulated_world(prepared.backend)
        assert scene is not None
        stood = scene.base
        for _ in range(round(10.0 / prepared.backend.period)):
            prepared.backend.step()
        assert math.degrees(scene.base.turn(stood)) < 0.02
        assert scene.base.distance(stood) < 1e-4


def test_an_arm_on_a_slope_comes_to_rest(physics: type[PhysicsBackend]) -> None:
    """Its drive counts a speed towards where it belongs against what it is off, and else would swing on."""
    with prepare(TASK, physics.name, seed=3) as prepared:
        scene = simulated_world(prepared.backend)
        assert scene is not None
        stood = []
        for _ in range(round(3.0 / prepared.backend.period)):
            prepared.backend.step()
            stood.append(scene.joints.copy())
        assert float(np.ptp(stood[-40:], axis=0).max()) < 1e-4


def test_the_ground_is_as_rough_as_the_world_says(physics: type[PhysicsBackend]) -> None:
    """Beams from above meet it where its heights are."""
    world = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})
    backend = physics(load_robot("cart"), world, 0)
    try:
        engine = physics._start_engine(backend, False)
        terrain = Terrain(engine, GroundSpec(roughness_deg=2.0), 1)
        x, y = np.random.default_rng(0).uniform(-50.0, 50.0, (2, 4000))
        corners = [terrain.height(x + along, y + across) for along in (0.0, 0.6) for across in (-0.3, 0.3)]
        pitch = (corners[2] + corners[3] - corners[0] - corners[1]) / 1.2
        roll = (corners[1] + corners[3] - corners[0] - corners[2]) / 1.2
        assert np.degrees(pitch).std() == pytest.approx(2.0, abs=0.4)
        assert np.degrees(roll).std() == pytest.approx(2.0, abs=0.4)
        for tile in terrain.reach(1.0, 2.0):
            terrain.add(tile)
        for x, y in np.random.default_rng(1).uniform(-9.0, 9.0, (200, 2)).tolist():
            share = engine.free_shares(np.array([x, y, 1.0]), np.array([[x, y, -1.0]]))[0]
            assert 1.0 - 2.0 * share == pytest.approx(
                float(terrain.height(np.array(x), np.array(y))), abs=1e-3
            )
        engine.close()
    finally:
        backend.close()
