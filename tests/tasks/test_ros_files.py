"""A robot drives by what users of ROS have: a map anywhere, goals of nav2, a keepout and a speed mask."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from handcart.files.errors import FileError
from handcart.networks.task.preparing import check, prepare

TASKS = Path(__file__).resolve().parents[2] / "tasks"
GOALS = """\
waypoints:
  home: {pose: [1.0, 1.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0]}
  far: {pose: [5.0, 1.0, 0.0], orientation: [1.0, 0.0, 0.0, 0.0]}
"""
TASK = """\
format: handcart-task/1
title: Drive to a goal
robot: librarian
world: {parameter: map}
knowledge:
  map: {parameter: map}
  keepout: keepout.yaml
  speed_limits: {mask: speed.yaml, type: percent, base: 100.0, multiplier: -1.0}
  places: goals.yaml
  start: home
parameters: {map: MAP}
start: here
goal: there
situations: {here: {base: home}, there: {base: far}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: far}}
"""


def write_map(path: Path, level: np.ndarray, more: str = "") -> None:
    Image.fromarray(level.astype(np.uint8)).save(path.with_suffix(".pgm"))
    path.write_text(
        f"image: {path.with_suffix('.pgm')}\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n{more}",
        encoding="utf-8",
    )


@pytest.fixture
def task(tmp_path: Path) -> Path:
    """A hall of 6 m by 4 m whose map lies elsewhere; a zone in its middle is barred but for its north."""
    elsewhere, folder = tmp_path / "maps", tmp_path / "task"
    elsewhere.mkdir()
    folder.mkdir()
    hall = np.full((80, 120), 254)
    hall[[0, -1], :] = hall[:, [0, -1]] = 0
    write_map(elsewhere / "hall.yaml", hall)
    zone, slow = np.full((80, 120), 254), np.full((80, 120), 255)
    zone[40:, 56:64] = 0  # the lower half of the picture is the south
    slow[:, 50:70] = 255 - 204  # 80 %: of that 20 % of the top speed is left
    write_map(folder / "keepout.yaml", zone)
    write_map(folder / "speed.yaml", slow, "mode: scale\noccupied_thresh: 1.0\nfree_thresh: 0.0\n")
    (folder / "goals.yaml").write_text(GOALS, encoding="utf-8")
    (folder / "task.yaml").write_text(TASK.replace("MAP", str(elsewhere / "hall.yaml")), encoding="utf-8")
    return folder / "task.yaml"


def test_the_files_are_read(task: Path) -> None:
    with prepare(task) as prepared:
        model = prepared.model
        assert list(model.places) == ["home", "far"]
        assert model.map.unknown.sum() == 8 * 39  # the last row is wall
        assert not prepared.robot.localization.lost
        assert model.speed_limits is not None
        assert model.speed_limits.at(np.array([[3.0, 1.0], [1.0, 1.0]]), 1.0) == pytest.approx([0.2, 1.0])


def test_a_place_in_a_barred_zone_is_told(task: Path) -> None:
    goals = task.parent / "goals.yaml"
    goals.write_text(GOALS.replace("[5.0, 1.0", "[3.0, 1.0"), encoding="utf-8")
    with pytest.raises(
        FileError, match=r"goals.yaml:3:3: place 'far' lies where keepout.yaml keeps the robot out"
    ):
        check(task)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("keepout: keepout.yaml", "keepout: keepot.yaml", "task.yaml:7:12: missing file 'keepot.yaml'"),
        ("keepout: keepout.yaml", "keepout: ../../keepout.yaml", "task.yaml:7:12: the path"),
        ("mask: speed.yaml", "mask: sped.yaml", "task.yaml:8:24: missing file 'sped.yaml'"),
        ("type: percent", "type: relative", "task.yaml:8:42:"),
        ("mask: speed.yaml", "mask: goals.yaml", "goals.yaml:"),
        ("  map: {parameter: map}\n", "", "keepout is a mask over a map; needed: the key `map`"),
    ],
)
def test_a_wrong_mask_is_told(task: Path, old: str, new: str, words: str) -> None:
    """T12, T13"""
    text = task.read_text(encoding="utf-8")
    assert old in text
    task.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(FileError) as error:
        check(task)
    assert words in str(error.value)


@pytest.mark.slow
def test_the_base_goes_around_the_zone_and_slowly_where_it_has_to(task: Path) -> None:
    """Measured by the ground truth, with the simulated errors."""
    with prepare(task) as prepared:
        backend: Any = prepared.backend
        robot, binding = prepared.robot, prepared.task.network.actions[0].binding
        assert binding is not None
        radius, seen = prepared.robot.spec.footprint_radius_m, []
        action = binding.make(prepared.model)
        motion = action.motion(robot, prepared.model.view(action))
        for _ in motion:
            robot.step()
            base = backend.scene.base
            seen.append((base.x, base.y, abs(robot.driven[0]) if hasattr(robot, "driven") else 0.0))
    x, y, _ = np.array(seen).T
    assert x[-1] == pytest.approx(5.0, abs=0.05)
    inside = (x > 2.8) & (x < 3.2)
    assert y[inside].min() > 2.0 + radius - 0.02
    speed = np.hypot(np.diff(x), np.diff(y)) / robot.period
    slow, top = (x[1:] > 2.5) & (x[1:] < 3.5), robot.drive_limits.speed
    assert speed[slow].max() < 0.2 * top + 0.02
    assert speed[~slow].max() > 0.7 * top
