"""`handcart do`."""

from __future__ import annotations

from typing import Any

import pytest

from handcart.backends.backend import NotMovable
from handcart.backends.can.can_backend import CanBackend
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.networks.task.task_file import load_task
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.task_names import task_path


def test_do_start_puts_the_robot_at_the_place(handcart: Any) -> None:
    said = handcart("do", "STAND", "seconds=0.2", "--start", "shelf_3")
    assert (said.status, said.out.splitlines()[0]) == (0, "Success")
    files = RigFiles(start="shelf_3")
    with build_rig(files, put_at_start=True) as rig:
        simulated: Any = rig.backend
        truth = Pose2(*simulated.scene.base)
        assert truth.distance(rig.model.places["shelf_3"].pose) < 0.05


def test_do_start_at_an_unknown_place_is_refused(handcart: Any) -> None:
    said = handcart("do", "STAND", "seconds=0.2", "--start", "shelf_33")
    assert said.status == 2
    assert "no place 'shelf_33' to start at; did you mean 'shelf_3'" in said.err


def test_do_set_gives_a_parameter_of_the_task(handcart: Any) -> None:
    assert "map" in load_task(task_path("drive_map")).file.parameters
    said = handcart("do", "STAND", "seconds=0.2", "--knowledge", "drive_map", "--set", "mpa=x")
    assert said.status == 2
    assert "did you mean 'map'" in said.err


def test_do_set_without_a_task_is_refused(handcart: Any) -> None:
    said = handcart("do", "STAND", "seconds=0.2", "--set", "map=x")
    assert said.status == 2
    assert "--set without --knowledge" in said.err


def test_a_backend_that_cannot_put_its_robot_says_so() -> None:
    with pytest.raises(NotMovable, match="'can' cannot put its robot at a given place"):
        CanBackend.with_start(None, Pose2(0.0, 0.0, 0.0))
