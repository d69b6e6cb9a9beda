"""Laying sensors in physics: a height field, wheels that touch it, sensors that stand on it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.body.physics_car import FRONT, REAR
from handcart.backends.physics.engine.engine import GRAVITY_M_S2
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.physics.world.terrain import Terrain
from handcart.backends.simulation.field.field_props import FieldProps
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.evaluation.judging.survey import simulated_world
from handcart.evaluation.trials.rig import Rig
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import prepare
from handcart.primitives.field.deploy import Deploy
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.numerics.arrays import FloatArray

from ...conftest import Copier

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"


@pytest.mark.slow
def test_a_sensor_is_laid_and_a_killed_run_goes_on(tmp_path: Path, copier: type[Copier]) -> None:
    """On one engine: checkpoints of the other are in test_resume.py, and it lays sensors below."""
    (tmp_path / "one.csv").write_text("name,x_m,y_m\nonly,4,-0.75\n", encoding="utf-8")
    settings = {"targets": str(tmp_path / "one.csv"), "wait_s": "5", "together": "true"}
    left = tmp_path / "left"
    whole, status = run_task(
        TASK,
        tmp_path,
        RunOptions(
            backend="mujoco", settings=settings, seed=2, checkpoints=True, observers=(copier(2, left),)
        ),
    )
    assert status == 0
    metrics = whole["metrics"]
    assert metrics["untrue"] == []
    assert metrics["placed"] == 1
    assert metrics["error_mm_max"] < 600.0
    again, status = resume_task(left, None, RunOptions(observers=(copier(0, left),)))
    assert status == 0
    ((first,), (second,)) = (item["metrics"]["placements"] for item in (whole, again))
    assert abs(first["true_x_mm"] - second["true_x_mm"]) < 30.0
    assert abs(first["true_y_mm"] - second["true_y_mm"]) < 30.0


@contextmanager
def beside_a_target(backend: str, seed: int, folder: Path) -> Iterator[Rig]:
    """A car that stands beside its target, on ground that only the seed tells."""
    (folder / "one.csv").write_text("name,x_m,y_m\nhere,0.05,-0.76\n", encoding="utf-8")
    (folder / "world.yaml").write_text(
        "format: handcart-world/1\nstart: {x_m: 0.0, y_m: 0.0}\nground: {}\nsensors: {count: 1}\n",
        encoding="utf-8",
    )
    settings = {"targets": str(folder / "one.csv"), "world": str(folder / "world.yaml")}
    with prepare(TASK, backend, settings, seed) as prepared:
        yield Rig(prepared.robot, prepared.model, prepared.backend)


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "seed"), [("mujoco", 25), ("mujoco", 37), ("pybullet", 25)])
def test_sensor_stands_on_a_slope_where_a_dropped_one_falls(tmp_path: Path, backend: str, seed: int) -> None:
    """Slopes of 13 degrees along the fingers' stroke and of 15 aslant; PyBullet, which is slow, has one."""
    if backend == "pybullet":
        pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    with beside_a_target(backend, seed, tmp_path) as rig:
        assert isinstance(rig.do(Deploy(target="here", sure_mm=1000.0)), Success)
        scene = simulated_world(rig.backend)
        assert scene is not None
        (sensor,) = scene.of(FieldProps).sensors.values()
        for _ in range(200):
            rig.robot.step()
        assert sensor.rest is Rest.TABLE
        assert 9.0 < math.degrees(sensor.tilt()) < 17.0


@pytest.mark.slow
def test_what_the_fingers_let_go_at_home_the_magazine_takes_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without ground below it DEPLOY Fails: the same sensor is there again, and is laid next."""
    with beside_a_target("mujoco", 2, tmp_path) as rig:
        with monkeypatch.context() as patched:
            patched.setattr("handcart.primitives.field.deploy.GROUND_TOLERANCE_M", -0.06)
            assert isinstance(rig.do(Deploy(target="here", sure_mm=1000.0)), Fail)
        scene = simulated_world(rig.backend)
        assert scene is not None
        (sensor,) = scene.of(FieldProps).sensors.values()
        assert sensor.rest is Rest.TRAY
        hand = scene.world_T("hand")[:3, 3]
        rig.robot.step()
        assert float(np.linalg.norm(sensor.pose[:3, 3] - hand)) < 0.3


@pytest.mark.slow
def test_a_car_on_rockers_takes_half_of_what_one_wheel_stands_on(
    physics: type[PhysicsBackend], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Paper 001, section III: a hump of 0.1 m under the left front wheel; all wheels stay on the ground."""

    def hump(_: Terrain, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.asarray(0.1 * np.exp(-((x - 0.6) ** 2 + (y - 0.3) ** 2) / 0.08))

    monkeypatch.setattr(Terrain, "height", hump)
    with prepare(TASK, physics.name, seed=0) as prepared:
        backend = prepared.backend
        assert isinstance(backend, PhysicsBackend)
        for _ in range(40):
            backend.step()
        wheels = [backend.link_pose(name)[:3, 3] for name in (*REAR, *FRONT)]
        for at in wheels:
            ground = hump(backend, *at[:2, None])[0]  # type: ignore[arg-type]
            assert at[2] - 0.15 - ground == pytest.approx(0.0, abs=0.02)
        left, right = (wheels[2 + side][2] - wheels[side][2] for side in (0, 1))
        pitch = -math.asin(float(backend.link_pose("base")[2, 0]))
        assert left > 0.08
        assert abs(right) < 0.01
        assert -pitch == pytest.approx(0.5 * (left + right) / 0.6, abs=0.006)


@pytest.mark.slow
def test_a_car_stands_on_rough_ground(physics: type[PhysicsBackend]) -> None:
    with prepare(TASK, physics.name, seed=0) as prepared:
        scene = simulated_world(prepared.backend)
        assert scene is not None
        stood = scene.base
        for _ in range(round(4.0 / prepared.backend.period)):
            prepared.backend.step()
        assert math.degrees(scene.base.turn(stood)) < 0.02
        assert scene.base.distance(stood) < 1e-4


@pytest.mark.slow
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


@pytest.mark.slow
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


def stands(physics: type[PhysicsBackend], softness: float, seconds: float = 4.0) -> tuple[float, float]:
    """How high a car's wheels stand on level ground that gives so, and what it weighs, in [m] and [N]."""
    world = world_model().model_validate(
        {
            "format": "handcart-world/1",
            "start": {"x_m": 0.0, "y_m": 0.0},
            "ground": {"roughness_deg": 0.0, "softness_mm_per_100n": softness},
        }
    )
    backend = physics(load_robot("el_verde"), world, 0)
    try:
        for _ in range(round(seconds / backend.period)):
            backend.step()
        heights = [backend.link_pose(name)[2, 3] for name in (*REAR, *FRONT)]
        weight = GRAVITY_M_S2 * sum(backend._body.mass(link) for link in backend._body.link_index)
        return float(np.mean(heights)), weight
    finally:
        backend.close()


@pytest.mark.slow
def test_wheels_sink_in_as_the_world_says(physics: type[PhysicsBackend]) -> None:
    (hard, weight), (soft, _) = (stands(physics, softness) for softness in (0.0, 4.0))
    on_one_point = 4e-5 * weight / 4
    assert on_one_point / 5 < hard - soft < on_one_point / 2


@pytest.mark.slow
def test_a_car_stands_still_on_ground_that_gives(tmp_path: Path) -> None:
    world = tmp_path / "world.yaml"
    text = TASK.with_name("world.yaml").read_text(encoding="utf-8")
    world.write_text(text.replace("ground: {}", "ground: {softness_mm_per_100n: 4.0}"), encoding="utf-8")
    with prepare(TASK, "mujoco", {"world": str(world)}, seed=0) as prepared:
        scene = simulated_world(prepared.backend)
        assert scene is not None
        for _ in range(round(5.0 / prepared.backend.period)):
            prepared.backend.step()
        stood = scene.base
        for _ in range(round(5.0 / prepared.backend.period)):
            prepared.backend.step()
        assert scene.base.distance(stood) < 5e-4
