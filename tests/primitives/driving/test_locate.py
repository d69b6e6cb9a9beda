"""LOCATE finds an unknown start, or reports that places look alike."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from handcart.backends.robot.robot_errors import UnknownStart
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.locate import Locate
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.pose2 import Pose2

DRIVE_MAP = Path(__file__).parents[3] / "tasks" / "drive_map"
TWINS = RigFiles(
    DRIVE_MAP / "twin_world.yaml", DRIVE_MAP / "twin_rooms.yaml", DRIVE_MAP / "twin_places.yaml", {}, ""
)


def truth_of(rig: Rig) -> Pose2:
    truth = rig.backend.ground_truth()
    assert truth is not None
    return truth.base


def symmetric_room(folder: Path, surprises: list[dict[str, object]] | None = None) -> RigFiles:
    """Write a map that looks the same after half a turn, and a robot in it."""
    cells = np.full((120, 200), 254, np.uint8)
    cells[:2] = cells[-2:] = cells[:, :2].T[:] = cells[:, -2:].T[:] = 0
    cells[30:40, 40:50] = cells[80:90, 150:160] = 0
    Image.fromarray(cells).save(folder / "map.png")
    header = "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
    (folder / "map.yaml").write_text(header + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    world = {
        "format": "handcart-world/1",
        "map": "map.yaml",
        "start": {"x_m": 3.5, "y_m": 3.2, "heading_deg": 70.0},
        "surprises": surprises or [],
    }
    (folder / "world.yaml").write_text(yaml.safe_dump(world))
    return RigFiles(folder / "world.yaml", folder / "map.yaml", None, {}, "")


@pytest.fixture
def twins() -> Iterator[Rig]:
    with build_rig(TWINS, robot="cart", is_start_known=False) as rig:
        yield rig


@pytest.mark.slow
def test_locate_drives_to_where_two_rooms_differ(twins: Rig) -> None:
    begun, locate = truth_of(twins), Locate()
    assert isinstance(twins.do(locate), Success)
    assert truth_of(twins).distance(begun) > 0.3  # the first scan fits both rooms
    assert twins.robot.localization.is_located
    assert twins.robot.pose.distance(truth_of(twins)) < 0.03
    assert twins.robot.pose.turn(truth_of(twins)) < math.radians(0.5)
    assert float(locate.facts["log_odds"]) > math.log(1e6)


@pytest.mark.slow
def test_move_to_refuses_by_name_until_the_pose_is_known(twins: Rig) -> None:
    begun = truth_of(twins)
    refused = twins.do(MoveTo(place="right_room"))
    assert isinstance(refused, Fail)
    wanted = "MOVE_TO needs the pose of the base on the map, which is not known; LOCATE finds it"
    assert refused.reason == wanted
    assert truth_of(twins) == begun
    assert isinstance(twins.do(Locate()), Success)
    assert isinstance(twins.do(MoveTo(place="right_room")), Success)
    assert truth_of(twins).distance(twins.model.places["right_room"].pose) < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("unmapped", [False, True])
def test_a_symmetric_room_is_ambiguous_and_restored(unmapped: bool, tmp_path: Path) -> None:
    """Also with a box that is on no map and so gives no information."""
    box = {"name": "box", "x_m": 5.5, "y_m": 2.0, "heading_deg": 20.0, "size_m": [0.5, 0.4, 0.6]}
    files = symmetric_room(tmp_path, [box] if unmapped else None)
    with build_rig(files, robot="cart", is_start_known=False) as rig:
        begun, locate = truth_of(rig), Locate()
        failed = rig.do(locate)
        assert isinstance(failed, Fail)
        assert failed.permanent
        assert "ambiguous: " in failed.reason
        assert "2 places explain the scans alike: " in failed.reason
        named = locate.evidence.points["hypotheses"][:, :2]
        image = np.array([10.0 - begun.x, 6.0 - begun.y])
        for true in (np.array([begun.x, begun.y]), image):
            assert np.hypot(*(named - true).T).min() < 1.5
        assert truth_of(rig).distance(begun) < 0.03
        assert not rig.robot.localization.is_located


@pytest.mark.slow
def test_a_known_pose_resolves_a_symmetric_room(tmp_path: Path) -> None:
    """Nothing moves, and the pose stays known."""
    files = symmetric_room(tmp_path)
    with build_rig(files, robot="cart") as rig:
        rig.robot.localization.locate(truth_of(rig), 1e-4 * np.eye(3))
        begun = truth_of(rig)
        assert isinstance(rig.do(Locate()), Success)
        assert truth_of(rig) == begun
        assert rig.robot.localization.is_located


def test_the_map_is_no_obstacle_while_the_pose_is_unknown(tmp_path: Path) -> None:
    """The base believes to be at the map's corner, where it would collide."""
    with build_rig(symmetric_room(tmp_path), robot="cart", is_start_known=False) as rig:
        for _ in range(20):
            rig.robot.base.drive(0.2, 0.0)
            rig.robot.step()
        assert rig.robot.held is None
        assert rig.robot.localization.travel.left > 0.1


@pytest.mark.slow
def test_state_of_an_unlocated_robot_is_restored(twins: Rig) -> None:
    for _ in range(3):
        twins.robot.step()
    state = twins.robot.state()
    assert isinstance(twins.do(Locate()), Success)
    located = twins.robot.state()
    twins.robot.set_state(state)
    assert not twins.robot.localization.is_located
    twins.robot.set_state(located)
    assert twins.robot.localization.is_located


def test_a_robot_that_sees_no_map_cannot_start_anywhere() -> None:
    with pytest.raises(UnknownStart, match="needed: a map, a lidar, and the localizer scan or odometry"):
        build_rig(TWINS, robot="atrv", is_start_known=False)


def kidnapping_twins(folder: Path, at_s: float) -> RigFiles:
    """Write the world of the twin rooms, in which a person carries the robot into the other room."""
    world = yaml.safe_load(TWINS.world.read_text(encoding="utf-8"))
    to = {"x_m": 6.0, "y_m": 5.0, "heading_deg": -70.0}
    world |= {"map": str(DRIVE_MAP / "twin_rooms.yaml"), "kidnap": {"at_s": at_s, "to": to}}
    world["start"] = {"x_m": 15.0, "y_m": 4.0, "heading_deg": 180.0}
    (folder / "world.yaml").write_text(yaml.safe_dump(world), encoding="utf-8")
    return RigFiles(folder / "world.yaml", TWINS.map, TWINS.places, {}, "right_room")


def test_a_robot_lifted_while_it_drives_gives_up_at_once(tmp_path: Path) -> None:
    with build_rig(kidnapping_twins(tmp_path, 4.0), robot="cart") as rig:
        outcome = rig.do(MoveTo(place="left_room"))
        assert isinstance(outcome, GiveUp)
        assert "it was lifted and set down elsewhere" in outcome.reason
        assert rig.robot.time < 5.5
        assert rig.robot.localization.lifted is not None


@pytest.mark.slow
def test_a_robot_lifted_at_rest_refuses_until_it_is_located(tmp_path: Path) -> None:
    with build_rig(kidnapping_twins(tmp_path, 3.0), robot="cart") as rig:
        while rig.robot.time < 6.0:
            rig.robot.step()
        refused = rig.do(MoveTo(place="left_room"))
        assert isinstance(refused, Fail)
        assert refused.reason.startswith(
            "MOVE_TO needs the pose of the base on the map, which is not known: "
        )
        assert isinstance(rig.do(Locate()), Success)
        assert rig.robot.pose.distance(truth_of(rig)) < 0.03
        assert isinstance(rig.do(MoveTo(place="left_room")), Success)
        assert truth_of(rig).distance(rig.model.places["left_room"].pose) < 0.04


@pytest.mark.slow
def test_stuck_wheels_end_the_search(twins: Rig) -> None:
    """The base is driven and stays where it is."""
    drive = twins.robot.base._base.drive
    twins.robot.base._base.drive = lambda speed, turn_rate: drive(0.0, 0.0)  # type: ignore[method-assign]
    assert not isinstance(twins.do(Locate()), Success)
    assert twins.robot.time < 120.0
