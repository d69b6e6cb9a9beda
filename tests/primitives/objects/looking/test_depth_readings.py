"""Objects without tags: identified by their sizes and beliefs, or reported as ambiguous."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.evaluation.trials.rig import Rig
from handcart.files.errors import FileError
from handcart.networks.task.preparing import load_model
from handcart.networks.task.task_file import load_task
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.looking.depth_readings import ObjectBelief, Standing, contradiction, identify
from handcart.primitives.objects.pick import Pick
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.geometry.transform import transform
from handcart.robotics.perception.objects.known_solids import SolidCandidate
from handcart.robotics.perception.objects.standing_clusters import PointCluster

from ..fetching import TASK, changed, rig_with, scene_of

CAMERA = "{kind: depth_camera, frame: camera, width_px: 320, height_px: 240, focal_px: 280}"
DEPTH = f"sensors: {{depth: {CAMERA}}}\n"
PARCEL = ObjectKind(size_mm=(60, 90, 80))


def seen_at(x: float, y: float, *names: str, is_upright: bool = True) -> Standing:
    """Return something that may be one of these kinds."""
    points = np.array([[x, y, 0.08]])
    cluster = PointCluster(points, 0.08, points[:, :2], 0.002, 0.0015, np.array([0.0, 0.0, 0.5]))
    pose = transform((x, y, 0.0))
    return Standing(
        cluster, tuple(SolidCandidate(n, pose, 1e-6 * np.eye(3), is_upright, 1e-3) for n in names)
    )


def place_of(found: list[Standing], *beliefs: ObjectBelief) -> tuple[float, float]:
    """Return where `mine` is."""
    every = (ObjectBelief("mine", (0.5, 0.0), 0.04, 0.0), *beliefs)
    place = identify("mine", "parcel", PARCEL, found, every, np.eye(4), 2)
    x, y = place.base_T_object[:2, 3].tolist()
    return x, y


def cause_of(found: list[Standing], *beliefs: ObjectBelief) -> str:
    with pytest.raises(Discrepancy) as caught:
        place_of(found, *beliefs)
    return str(caught.value.cause)


def test_only_object_of_its_kind_is_told() -> None:
    assert place_of([seen_at(0.52, 0.01, "parcel"), seen_at(0.7, 0.0, "can")]) == pytest.approx((0.52, 0.01))


def test_two_kinds_that_fit_are_ambiguous() -> None:
    assert "ambiguous" in cause_of([seen_at(0.5, 0.0, "parcel", "carton")])


def test_two_like_one_known_object_are_ambiguous() -> None:
    assert "ambiguous" in cause_of([seen_at(0.5, 0.0, "parcel"), seen_at(0.7, 0.0, "parcel")])


def test_two_known_objects_of_one_kind_are_told_by_belief() -> None:
    pair = [seen_at(0.72, 0.0, "parcel"), seen_at(0.48, 0.0, "parcel")]
    assert place_of(pair, ObjectBelief("other", (0.7, 0.0), 0.04, 0.0)) == pytest.approx((0.48, 0.0))
    near = [seen_at(0.52, 0.0, "parcel"), seen_at(0.53, 0.05, "parcel")]
    assert "ambiguous" in cause_of(near, ObjectBelief("other", (0.55, 0.0), 0.04, 0.0))


def test_other_object_of_the_kind_is_not_taken_for_it() -> None:
    assert "not_seen" in cause_of([seen_at(0.9, 0.0, "parcel")], ObjectBelief("other", (0.9, 0.0), 0.04, 0.0))


def test_only_one_of_its_kind_far_from_belief_is_ambiguous() -> None:
    assert "ambiguous" in cause_of([seen_at(0.75, 0.0, "parcel")])


def test_fallen_object_is_misplaced() -> None:
    assert "misplaced" in cause_of([seen_at(0.5, 0.0, "parcel", is_upright=False)])


def without_tag(folder: Path, *changes: tuple[str, str]) -> Rig:
    """Return a rig before table A whose robot has a depth camera; the parcel has no tag."""
    shutil.copytree(SHIPPED_FOLDER / "librarian", folder / "librarian")
    with (folder / "librarian" / "robot.yaml").open("a", encoding="utf-8") as file:
        file.write(DEPTH)
    tag = ("    tags: [{id: 7, side_mm: 40}]\n", "")
    world = changed(folder, "world.yaml", tag, *changes)
    objects = changed(folder, "objects.yaml", (", tags: [{id: 7, side_mm: 40}]", ""))
    rig = rig_with(objects, world, robot=str(folder / "librarian" / "robot.yaml"), seed=3)
    assert isinstance(rig.do(MoveTo(place="table_a")), Success)
    return rig


def thing(rig: Rig) -> Any:
    return scene_of(rig).thing_named("object parcel_1")


@pytest.mark.slow
def test_parcel_without_tag_is_found_and_picked(tmp_path: Path) -> None:
    rig = without_tag(tmp_path)
    outcome = rig.do(LookFor(object="parcel_1", tolerance_deg=6.0))
    assert isinstance(outcome, Success), outcome
    seen, true = rig.model.of(Objects).seen("parcel_1"), thing(rig).pose
    assert seen is not None
    assert (seen.pose.x, seen.pose.y) == pytest.approx(true[:2, 3], abs=0.012)
    assert isinstance(rig.do(Pick(object="parcel_1")), Success)
    assert scene_of(rig).held is thing(rig)


@pytest.mark.parametrize(
    ("names", "height", "words"),
    [
        (("parcel",), 0.08, ""),
        ((), 0.081, ""),
        (("tin", "parcel"), 0.08, ""),
        (("tin",), 0.08, "a tin"),
        ((), 0.076, "something 76 mm high"),
    ],
)
def test_tag_on_another_solid_is_noticed(names: tuple[str, ...], height: float, words: str) -> None:
    found = seen_at(0.5, 0.1, *names)
    points = np.tile([[0.5, 0.1, height]], (40, 1))
    found = found._replace(cluster=found.cluster._replace(points=points, top=height))
    place = transform((0.5, 0.1, 0.0))
    assert contradiction([found], np.eye(4), place, "parcel", PARCEL) == words


@pytest.mark.slow
def test_parcel_of_another_size_is_not_picked(tmp_path: Path) -> None:
    rig = without_tag(tmp_path, ("size_mm: [60, 90, 80]\n    sigma", "size_mm: [60, 75, 95]\n    sigma"))
    outcome = rig.do(LookFor(object="parcel_1", max_views=3))
    assert isinstance(outcome, Fail)
    assert "something" in outcome.reason


def test_object_without_tags_needs_a_depth_camera(tmp_path: Path) -> None:
    objects = changed(tmp_path, "objects.yaml", (", tags: [{id: 7, side_mm: 40}]", ""))
    rig = rig_with(objects)
    look: Any = LookFor(object="parcel_1")
    reason = look.unmet_precondition(rig.robot, rig.model.view(look))
    assert reason == "parcel_1 has no tags, and the robot has no depth camera; needed: one of them"


def test_a_task_with_an_object_that_nothing_shows_is_refused(tmp_path: Path) -> None:
    shutil.copytree(TASK, tmp_path / "task")
    objects = tmp_path / "task" / "objects.yaml"
    objects.write_text(objects.read_text().replace(", tags: [{id: 7, side_mm: 40}]", ""))
    task = load_task(tmp_path / "task" / "task.yaml")
    model, _ = load_model(task)
    with pytest.raises(FileError, match=r"LOOK_FOR can never be done: parcel_1 has no tags, and the robot"):
        task.check_kinds((Arm, Base, Camera, Gripper, RangeSensor), model)
    task.check_kinds((Arm, Base, Camera, Gripper, RangeSensor, DepthCamera), model)
