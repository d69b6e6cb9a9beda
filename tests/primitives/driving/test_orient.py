"""Tests of ORIENT: a robot with unknown heading."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.pose_covariance import worst_sigmas
from handcart.evaluation.trials.rig import Rig
from handcart.files.errors import FileError
from handcart.networks.task.preparing import prepare
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.driving.orient import Orient
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success

TASK = Path(__file__).parents[3] / "tasks" / "deploy_straight" / "task.yaml"
WORLD = """\
format: handcart-world/1
start: {x_m: 0.0, y_m: 0.0, heading_deg: 70.0}
ground: {}
sensors: {count: 2}
"""


@pytest.fixture
def unheaded(tmp_path: Path) -> Callable[..., Any]:
    """Return a maker of rigs whose robot's file has an unknown heading; the true one is 70 degrees."""

    @contextmanager
    def make(surprises: str = "") -> Iterator[Rig]:
        folder = tmp_path / "robot"
        shutil.copytree(robot_path("el_verde").parent, folder)
        text = (folder / "robot.yaml").read_text(encoding="utf-8")
        assert "\n  period_s: 1.0\n" in text
        changed = text.replace("\n  period_s: 1.0\n", "\n  start_heading_deg: unknown\n  period_s: 1.0\n")
        (folder / "robot.yaml").write_text(changed, encoding="utf-8")
        (tmp_path / "world.yaml").write_text(WORLD + surprises, encoding="utf-8")
        settings = {"robot": str(folder / "robot.yaml"), "world": str(tmp_path / "world.yaml")}
        with prepare(TASK, None, settings, 2) as prepared:
            yield Rig(prepared.robot, prepared.model, prepared.backend)

    return make


@pytest.mark.slow
def test_before_the_heading_shows_a_way_is_as_certain_as_it_is_long(unheaded: Callable[..., Any]) -> None:
    """Its uncertainty is that of wheels and gyros, not that of a fix."""
    with unheaded() as rig:
        where, robot = rig.robot.localization, rig.robot
        where.set_origin()
        stood = where.sigma
        for _ in range(160):
            robot.base.drive(0.5, 0.0)
            robot.step()
        assert not where.heading_known
        assert stood[0] < 0.005 < where.sigma[0] < 0.2
        assert stood[1] < where.sigma[1] < math.radians(3.0)
        assert where.sigma[0] == pytest.approx(worst_sigmas(where.displacement.covariance)[0])


@pytest.mark.slow
def test_it_drives_ahead_until_the_heading_shows(unheaded: Callable[..., Any]) -> None:
    with unheaded() as rig:
        where = rig.robot.localization
        assert not where.heading_known
        refused = rig.do(MoveTo(place="1"))
        assert isinstance(refused, Fail)
        assert refused.reason == "the heading is unknown; run ORIENT first"
        assert refused.permanent
        assert isinstance(rig.do(Orient()), Success)
        assert where.heading_known
        truth = rig.backend.scene.base
        assert 5.0 < math.hypot(*truth[:2]) < 30.0
        off, sigma = rig.robot.pose.turn(truth), where.sigma[1]
        assert off < 3.0 * sigma + math.radians(0.5)
        again = rig.backend.scene.base
        assert isinstance(rig.do(Orient()), Success)
        assert rig.backend.scene.base.distance(again) < 0.01


@pytest.mark.slow
def test_what_stands_ahead_is_a_fail_and_it_drives_back(unheaded: Callable[..., Any]) -> None:
    """The obstacle is 5 m ahead: too near for the heading to be determined."""
    x, y = 5.0 * math.cos(math.radians(70.0)), 5.0 * math.sin(math.radians(70.0))
    crate = f"surprises: [{{name: crate, x_m: {x:.2f}, y_m: {y:.2f}, size_m: [1.0, 1.0, 1.0]}}]\n"
    with unheaded(crate) as rig:
        failed = rig.do(Orient())
        assert isinstance(failed, Fail), failed
        assert failed.reason.startswith("the base can't drive ahead")
        assert math.hypot(*rig.backend.scene.base[:2]) < 0.3


@pytest.mark.slow
def test_too_short_a_way_is_a_fail(unheaded: Callable[..., Any]) -> None:
    with unheaded() as rig:
        failed = rig.do(Orient(longest_m=2.0))
        assert isinstance(failed, Fail), failed
        assert failed.reason == "it doesn't show which way the robot heads"
        assert math.hypot(*rig.backend.scene.base[:2]) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("is_empty", [True, False])
def test_a_lidar_that_stays_stale_while_orienting_is_named(
    unheaded: Callable[..., Any], is_empty: bool
) -> None:
    """Also in an empty field, where all scans are alike: new ones are other objects."""
    crate = "{{name: {0}, x_m: {1}, y_m: {2}, size_m: [3.0, 3.0, 1.0]}}"
    crates = crate.format("left", -6, 3), crate.format("right", 6, 0)
    with unheaded("" if is_empty else f"surprises: [{', '.join(crates)}]\n") as rig:
        sensor = rig.robot.lidar._sensor
        take = sensor.scan
        kept: list[Any] = []
        rows: list[tuple[float, Any]] = []

        def scan() -> Any:
            if rig.robot.time < 3.0:
                kept[:] = [take()]
            rows.append((rig.robot.time, rig.backend.scene.base))
            assert rig.robot.time < 30.0, "it holds without end"
            return kept[0]

        sensor.scan = scan
        given_up = rig.do(Orient())
        assert isinstance(given_up, GiveUp), given_up
        assert given_up.cause is causes.SENSOR_FAULT
        assert given_up.reason == "the lidar repeats its last scan"
        assert rows[-1][0] < 12.0
        at_rest = [base for time, base in rows if time > 6.0]
        assert at_rest[0].distance(at_rest[-1]) < 0.02


def test_a_robot_that_never_could_find_its_heading_is_refused(tmp_path: Path) -> None:
    """Gyros measure turns alone: driving ahead would be useless."""
    folder = tmp_path / "robot"
    shutil.copytree(robot_path("el_verde").parent, folder)
    path = folder / "robot.yaml"
    text = path.read_text(encoding="utf-8").replace("localizer: gps_filter", "localizer: gyro")
    path.write_text(text.replace("gps: ", "gps:\n  start_heading_deg: unknown", 1), encoding="utf-8")
    with pytest.raises(FileError, match="gyro looks at no fix that could tell it"):
        load_robot(str(path))
