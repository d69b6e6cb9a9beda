"""A run over the bench is resumed from its checkpoint as one without topics in between."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.saved_state import NotAState, pack, unpack
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.networks.runs.run_options import RunOptions
from tests.conftest import Copier

from .conftest import Make

TOUR = Path(__file__).parents[3] / "tasks" / "drive_map" / "task.yaml"


def moved(backend: RosBackend, periods: int) -> Iterator[tuple[object, ...]]:
    """Yield the readings of each period while base, arm and fingers move."""
    base, arm = backend.get(Base), backend.get(Arm)  # type: ignore[type-abstract]
    gripper, lidar = backend.get(Gripper), backend.get(RangeSensor)  # type: ignore[type-abstract]
    assert base is not None and arm is not None and gripper is not None and lidar is not None
    for period in range(periods):
        base.drive(0.2, 0.3)
        joints = arm.command()
        joints[1] += 0.01
        arm.move(joints)
        gripper.move(0.01 + 0.002 * (period % 5))
        backend.step()
        yield (
            *base.wheel_travel(),
            *arm.joints(),
            *arm.command(),
            gripper.width(),
            gripper.command(),
            gripper.closed_on_something(),
            *np.nan_to_num(lidar.scan().ranges, posinf=99.0),
            backend.true_base(),
        )


def test_readings_go_on_bit_for_bit_after_a_restored_state(make: Make) -> None:
    with make() as backend:
        list(moved(backend, 12))
        state = pack(backend.state())
        expected = list(moved(backend, 8))
    with make() as again:
        list(moved(again, 3))
        again.set_state(unpack(state))
        assert list(moved(again, 8)) == expected


def test_a_state_of_something_else_is_refused(make: Make) -> None:
    with make() as backend:
        state = backend.state()
        assert isinstance(state, dict)
        for key in state:
            with pytest.raises(NotAState, match=r"needed"):
                backend.set_state({name: value for name, value in state.items() if name != key})
        with pytest.raises(NotAState):
            backend.set_state({**state, "wheels": {"pose": 1}})


@pytest.mark.slow
def test_a_killed_run_over_the_bench_ends_as_if_it_had_not_been(tmp_path: Path, copier: type[Copier]) -> None:
    left = tmp_path / "left"
    options = {"robot": "cart", "tour": "[desk, home]"}
    whole, _ = run_task(
        TOUR,
        tmp_path / "runs",
        RunOptions("ros2", options, 2, bench="kinematic", checkpoints=True, observers=(copier(1, left),)),
    )
    again, status = resume_task(left, None, RunOptions(observers=(copier(0, left),)))
    assert status == 0
    assert (again["outcome"], again["sim_time_s"]) == ("Success", whole["sim_time_s"])
    assert again["metrics"] == whole["metrics"]
