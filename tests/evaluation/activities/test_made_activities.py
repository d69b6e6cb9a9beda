"""Worlds made from activities of BEHAVIOR-1K, judged by their own evaluator and by our survey."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("bddl", reason="the package bddl isn't installed: pip install 'handcart[bddl]'")

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.simulation.objects.object_props import ObjectProps
from handcart.evaluation.activities.activity_survey import ActivitySurvey
from handcart.evaluation.activities.making import MadeActivity, make
from handcart.evaluation.activities.true_things import true_things
from handcart.evaluation.judging.survey import SurveyedRun
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.files.errors import FileError
from handcart.networks.task.preparing import check
from handcart.networks.task.task_file import load_task
from handcart.primitives.activities.activity import Activity
from handcart.robotics.geometry.pose2 import Pose2
from tests.primitives.objects.fetching import scene_of

from .judged_start import start_holds


@pytest.fixture(scope="module")
def honey(tmp_path_factory: pytest.TempPathFactory) -> tuple[MadeActivity, Rig]:
    """The shortest activity, and a robot in its world."""
    folder = tmp_path_factory.mktemp("honey")
    made = make("store_honey", 0, folder)
    knowledge = {name: folder / f"{name}.yaml" for name in ("objects", "activity")}
    files = RigFiles(folder / "world.yaml", folder / "map.yaml", folder / "places.yaml", knowledge, "home")
    return made, build_rig(files)


def survey_of(rig: Rig) -> ActivitySurvey:
    run = SurveyedRun(rig.robot, rig.robot.spec, rig.model, scene_of(rig))
    assert ActivitySurvey.applies(run)
    return ActivitySurvey(run)


def put(rig: Rig, name: str, pose: Pose2, height: float) -> None:
    """Put an object somewhere in the true world."""
    scene_of(rig).of(ObjectProps).objects[name].pose[:] = pose.lift(height)


def figures_at(honey: tuple[MadeActivity, Rig], shift: float, height: float) -> Mapping[str, Any]:
    """Return the figures with the jar so far along and above its place in the cabinet."""
    made, rig = honey
    slot = made.room.at_end["jar__of__honey.n.01_1"]
    before = scene_of(rig).of(ObjectProps).objects["jar_of_honey_1"].pose.copy()
    put(rig, "jar_of_honey_1", slot.pose.compose(Pose2(0.0, shift, 0.0)), slot.level.height + height)
    figures = survey_of(rig).figures()
    scene_of(rig).of(ObjectProps).objects["jar_of_honey_1"].pose[:] = before
    return figures


def test_made_world_satisfies_the_initial_conditions(honey: tuple[MadeActivity, Rig]) -> None:
    made, rig = honey
    file = rig.model.of(Activity).activity
    assert file is not None
    things = true_things(made.definition, file, scene_of(rig))
    assert start_holds(made.definition, things)
    assert not start_holds(made.definition, {**things, "countertop.n.01_1": things["cabinet.n.01_1"]})


def test_untouched_activity_is_done_by_neither_verdict(honey: tuple[MadeActivity, Rig]) -> None:
    figures = survey_of(honey[1]).figures()
    assert not figures["activity_bddl"]
    assert not figures["activity_ours"]
    assert figures["activity_bddl_wrong"] == ["jar__of__honey1 is inside cabinet1"]


def test_done_activity_is_done_by_both_verdicts(honey: tuple[MadeActivity, Rig]) -> None:
    figures = figures_at(honey, 0.0, 0.0)
    assert figures["activity_bddl"]
    assert figures["activity_ours"]
    assert figures["activity_agreed"]


def test_thing_before_the_cabinet_is_done_by_neither_verdict(honey: tuple[MadeActivity, Rig]) -> None:
    figures = figures_at(honey, -0.4, 0.0)
    assert not figures["activity_bddl"]
    assert not figures["activity_ours"]


def test_floating_thing_is_a_difference_of_the_verdicts(honey: tuple[MadeActivity, Rig]) -> None:
    figures = figures_at(honey, 0.0, 0.05)
    assert figures["activity_bddl"]  # their `inside` doesn't ask for a support
    assert not figures["activity_agreed"]


def test_books_under_boards_can_be_gripped_anew_for_a_box(tmp_path: Path) -> None:
    """From a bookcase they are gripped from the front, into a box they go from above."""
    room = make("boxing_books_up_for_storage", 0, tmp_path).room
    assert room.has_side_table
    objects = yaml.safe_load((tmp_path / "objects.yaml").read_text(encoding="utf-8"))
    assert objects["surfaces"]["side_table"]["kinds"] == ["book"]
    network = load_task(tmp_path / "task.yaml").network
    routes = {(action.do, action.source, action.target) for action in network.actions}
    assert ("PLACE", "aside_book_1", "rested_book_1") in routes
    assert ("PICK", "found_book_1", "regripped_book_1") in routes
    assert "side_table" in {place.name for place in check(tmp_path / "task.yaml").computed}


def test_things_that_go_from_table_to_table_need_no_side_table(
    honey: tuple[MadeActivity, Rig],
) -> None:
    assert not honey[0].room.has_side_table


def test_unknown_activity_is_refused_with_the_nearest_name(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"unknown activity 'store_hony'.*did you mean 'store_honey'"):
        make("store_hony", 0, tmp_path)


def test_file_of_a_robot_is_named_from_the_task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(SHIPPED_FOLDER / "librarian", tmp_path / "robot")
    monkeypatch.chdir(tmp_path)
    make("store_honey", 0, Path("honey"), "robot/robot.yaml")
    assert load_task(Path("honey/task.yaml")).robot == str(tmp_path / "robot" / "robot.yaml")
    with pytest.raises(FileError, match=r"can't name a file that is not below .*; allowed: a robot's name"):
        make("store_honey", 0, Path("far/honey"), "robot/robot.yaml")
    assert not Path("far").exists()


def test_unknown_thing_is_refused_at_its_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"problem0\.bddl:\d+:\d+: no size is known for 'bicycle\.n\.01'"):
        make("putting_bike_in_garage", 0, tmp_path)
    assert not list(tmp_path.iterdir())


def test_state_that_is_not_simulated_is_refused_at_its_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r":11:10: the condition 'broken' isn't simulated; allowed: ontop"):
        make("fixing_broken_table", 0, tmp_path)


def test_thing_too_wide_for_the_fingers_is_refused_or_scaled(tmp_path: Path) -> None:
    with pytest.raises(
        FileError, match=r"jar__of__honey\.n\.01_1 is too wide for the fingers: 62 mm; allowed: at most"
    ):
        make("store_honey", 0, tmp_path, robot="toyama")
    made = make("store_honey", 0, tmp_path, robot="toyama", scale=True)
    assert made.room.sizes["jar__of__honey.n.01_1"].size_mm[0] < 62.0
    assert any("made narrower" in line for line in made.words())
