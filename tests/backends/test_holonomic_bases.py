"""Backends that drive a base in any direction, and those that do not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.base import Base, HolonomicBase
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import backend_class, make_backend
from handcart.backends.robot.guarded_base import SIDE_MARGIN_M
from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError
from handcart.networks.task.preparing import check
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.task_names import task_path

WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0, heading_deg: 0}
walls:
  - {from_m: [-3, 1], to_m: [3, 1]}
"""
HOLONOMIC = ("kinematic", "mujoco")
START = Pose2(0.0, 0.0, 0.0)
Make = Callable[..., Backend]


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    made: list[Backend] = []

    def one(name: str, errors: bool = False) -> Backend:
        if name == "mujoco":
            pytest.importorskip("mujoco")
        world, spec = tmp_path / "world.yaml", load_robot("cart/mecanum")
        world.write_text(WORLD, encoding="utf-8")
        made.append(make_backend(name, spec if errors else spec.without_errors(), world, 0))
        return made[-1]

    yield one
    for backend in made:
        backend.close()


def base_of(backend: Backend) -> HolonomicBase:
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert isinstance(base, HolonomicBase)
    return base


def true_pose(backend: Backend) -> Pose2:
    truth = backend.ground_truth()
    assert truth is not None
    return truth.base


@pytest.mark.parametrize("name", HOLONOMIC)
@pytest.mark.parametrize(
    ("command", "end"),
    [
        ((0.0, 0.0, -0.4), (0.0, -0.8, 0.0)),
        ((0.3, 0.0, -0.3), (0.6, -0.6, 0.0)),
        ((0.0, 0.5, 0.0), (0.0, 0.0, 1.0)),
    ],
)
def test_it_drives_as_commanded(
    make: Make, name: str, command: tuple[float, float, float], end: tuple[float, ...]
) -> None:
    backend = make(name)
    base = base_of(backend)
    for _ in range(round(2.0 / backend.period)):
        base.drive(*command)
        backend.step()
    assert true_pose(backend) == pytest.approx(end, abs=0.02)
    left, right, sideways = base.wheel_travel()
    assert (0.5 * (left + right), sideways) == pytest.approx((2.0 * command[0], 2.0 * command[2]))
    assert (right - left) / 0.7 == pytest.approx(2.0 * command[1])


@pytest.mark.parametrize("name", HOLONOMIC)
def test_it_is_kept_off_a_wall_beside_it_and_drives_away(make: Make, name: str) -> None:
    backend = make(name)
    robot = Robot(backend, load_robot("cart/mecanum"), START)
    for _ in range(120):
        robot.base.drive(0.1, 0.0, 0.45)
        robot.step()
    there = true_pose(backend)
    assert 0.0 < 1.0 - there.y - robot.spec.footprint_radius_m < 0.1 + SIDE_MARGIN_M
    assert robot.held is not None
    for _ in range(20):
        robot.base.drive(0.0, 0.0, -0.4)
        robot.step()
    assert true_pose(backend).y < there.y - 0.2
    assert robot.held is None


@pytest.mark.parametrize(
    "bad", [(0.0, 0.0, 0.51), (0.0, 0.0, math.nan), (0.5, 0.0, 0.4), (0.61, 0.0, 0.0), (0.0, 9.0, 0.1)]
)
def test_commands_beyond_its_limits_are_refused(make: Make, bad: tuple[float, float, float]) -> None:
    with pytest.raises(CommandError, match="allowed"):
        base_of(make("kinematic")).drive(*bad)


@pytest.mark.parametrize("name", HOLONOMIC)
def test_unequal_wheels_turn_a_base_that_drives_sideways(make: Make, name: str) -> None:
    backend = make(name, errors=True)
    for _ in range(80):
        base_of(backend).drive(0.0, 0.0, -0.4)
        backend.step()
    truth = true_pose(backend)
    assert 1e-4 < abs(truth.theta) < 0.05
    assert 1e-3 < abs(truth.y + 80 * 0.4 * backend.period) < 0.2


def test_mujoco_pushes_it_no_harder_than_rollers_hold(make: Make) -> None:
    """To accelerate to 0.5 m/s in one period of 0.05 s would take more than the rollers' friction."""
    backend = make("mujoco")
    speeds = []
    for _ in range(5):
        before = true_pose(backend)
        base_of(backend).drive(0.5, 0.0)
        backend.step()
        speeds.append(before.distance(true_pose(backend)) / backend.period)
    assert 0.1 < speeds[0] < 0.3
    assert speeds[-1] == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("name", ["can", "pybullet"])
def test_other_backends_refuse_it_by_name(name: str) -> None:
    if name == "pybullet":
        pytest.importorskip("pybullet")
    assert "holonomic" not in backend_class(name).drive_kinds
    with pytest.raises(FileError, match=f"robot=cart/mecanum: the backend '{name}' drives no holonomic base"):
        check(task_path("drive_map"), name, {"robot": "cart/mecanum"})


def test_a_checkpoint_goes_on_to_the_last_bit(make: Make) -> None:
    ends = []
    for saves in (False, True):
        backend = make("kinematic", errors=True)
        for number in range(20):
            base_of(backend).drive(0.1, 0.2, -0.2)
            backend.step()
            if saves and number == 9:
                state, backend = backend.state(), make("kinematic", errors=True)
                backend.set_state(state)
        ends.append((tuple(true_pose(backend)), tuple(base_of(backend).wheel_travel())))
    assert ends[0] == ends[1]
