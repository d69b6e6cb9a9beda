from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import UnknownBackend, backend_names, make_backend
from handcart.backends.simulation.world_files.load_world import load_world
from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2


def test_the_kinematic_backend_is_made_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "world.yaml"
    path.write_text("format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n", encoding="utf-8")
    with make_backend("kinematic", load_robot("librarian"), path, seed=1) as backend:
        assert isinstance(backend, Backend)
        assert backend.name == "kinematic"
        backend.step()
    backend.close()


def test_an_unknown_name_is_told_with_the_nearest(tmp_path: Path) -> None:
    assert "kinematic" in backend_names()
    with pytest.raises(UnknownBackend, match="did you mean 'kinematic'"):
        make_backend("kinematik", load_robot("librarian"), tmp_path, seed=0)


def test_a_seed_that_no_journal_can_hold_is_refused() -> None:
    with pytest.raises(InputError, match=r"^seed 9223372036854775808; allowed: -9223372036854775808 to"):
        make_backend("kinematic", load_robot("librarian"), None, seed=2**63)


def test_a_backend_that_reads_files_itself_gets_one_for_a_map(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others are handed the world; see `Backend.read_world`."""

    class Reads(KinematicBackend):
        @classmethod
        def read_world(cls, path: Path, start: Pose2) -> Any:
            return None

        @classmethod
        def build(cls, robot: RobotFile, world: Any, seed: int) -> Any:
            assert load_world(world).start.x_m == 1.5
            return super().build(robot, world, seed)

    monkeypatch.setattr("handcart.backends.registry.backend_class", lambda name: Reads)
    chart = Path(__file__).parents[2] / "tasks" / "drive_map" / "map.yaml"
    backend: Any
    with make_backend("reads", load_robot("librarian"), chart, 0, Pose2(1.5, 1.0, 0.0)) as backend:
        assert len(backend.scene.solids) > 3


@pytest.mark.parametrize(
    ("drives", "part"),
    [
        ("can", "can.can_backend.Bench"),
        ("ros2", "ros2.ros_backend.LocalBench"),
    ],
)
def test_robot_of_a_bench_that_cannot_be_built_is_closed(
    drives: str, part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise ValueError("refused")

    closed = list[Backend]()
    monkeypatch.setattr(KinematicBackend, "close", lambda self: closed.append(self))
    monkeypatch.setattr(f"handcart.backends.{part}", refuse)
    path = tmp_path / "world.yaml"
    path.write_text("format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n", encoding="utf-8")
    with pytest.raises(ValueError, match="refused"):
        make_backend(drives, load_robot("cart"), path, seed=1, bench="kinematic")
    assert closed
