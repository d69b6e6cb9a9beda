"""Bringing a robot up, step by step, on the bench."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typing_extensions import override

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.bringup.axis_rungs import LimitsRung
from handcart.evaluation.bringup.ladder import ALL_RUNGS, BenchFirst, Ladder
from handcart.evaluation.bringup.operator import BenchOperator, ScriptedOperator
from handcart.evaluation.bringup.record import read
from handcart.evaluation.bringup.rung import RungFailed
from handcart.evaluation.bringup.site import Site
from handcart.evaluation.bringup.stop_rungs import StopTestRung
from handcart.evaluation.bringup.use_rungs import CalibrationRung
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.files.models.loading import load
from handcart.networks.runs.calibration import CALIBRATION_FILE, Calibration
from tests.tools.conftest import Said

NAMES = [rung.name for rung in ALL_RUNGS]
CART = Path(__file__).resolve().parents[3] / "backends" / "robots" / "cart"
ANSWERS = {
    "pressed": True,
    "left_wheel_direction": True,
    "left_wheel_scale": 100.4,
    "right_wheel_direction": True,
    "right_wheel_scale": 100.4,
    "signed_off": True,
}


@pytest.fixture
def site(tmp_path: Path) -> Site:
    """The cart, on a bench."""
    task = LIBRARY_FOLDER.parent / "drive_map" / "task.yaml"
    folder = tmp_path / "cart-bench"
    return Site(
        "cart", load_robot("cart"), BenchOperator(), folder, task, "kinematic", LIBRARY_FOLDER / "world.yaml"
    )


@pytest.fixture
def ladder(site: Site) -> Ladder:
    return Ladder(site)


def climb(ladder: Ladder, upto: str) -> list[Any]:
    """Climb up to that rung, it included."""
    tried = []
    while len(ladder.records()) <= NAMES.index(upto):
        tried.append(ladder.climb())
        if not tried[-1].passed:
            break
    return tried


@pytest.mark.slow
def test_the_lower_half(ladder: Ladder) -> None:
    """The steps from the interface to the stop test are recorded in order."""
    tried = climb(ladder, "stop_test")
    assert [item.rung for item in tried] == NAMES[:7]
    assert all(item.passed for item in tried)
    facts = {item.rung: item.facts for item in tried}
    assert facts["identify"]["nodes"]["left wheel"]["node"] == 1
    assert facts["read_back"]["supervision"]["left wheel"]["6007h:0"] == 3
    assert set(facts["emergency_stop"]["states"].values()) == {"SWITCH ON DISABLED"}
    assert facts["limits"]["left_out"] == "the robot has no joints"
    stops = facts["stop_test"]
    assert 0.0 < stops["program"]["max_m"] < stops["heartbeat"]["max_m"] < stops["heartbeat_allowed_m"]
    assert ladder.next is not None
    assert ladder.next.name == "calibrate"
    assert read(ladder.site.folder / "05_axes.yaml").answers["signed_off"] is True


def test_none_is_left_out_and_it_goes_on_where_it_was(site: Site) -> None:
    climb(Ladder(site), "identify")
    again = Ladder(site)
    assert [record.rung for record in again.records()] == NAMES[:2]
    (site.folder / "01_interface.yaml").unlink()
    assert again.next is ALL_RUNGS[0]


def test_another_robots_file_has_to_be_tried_anew(site: Site) -> None:
    """Changes by a calibration do not count."""
    climb(Ladder(site), "identify")
    drive = site.robot.drive
    site.robot = site.robot.model_copy(update={"drive": drive.model_copy(update={"wheel_radius_m": 0.101})})
    assert len(Ladder(site).records()) == 2
    site.robot = site.robot.model_copy(update={"drive": drive.model_copy(update={"top_speed_m_s": 0.9})})
    assert len(Ladder(site).records()) == 0


def test_the_bench_comes_first(site: Site, tmp_path: Path) -> None:
    climb(Ladder(site), "interface")
    real = Site("cart", site.robot, BenchOperator(), tmp_path / "cart", site.task)
    climb(Ladder(site), "interface")
    ladder = Ladder(real, rehearsed=site.folder)
    real.spec.model_copy(update={"interface": "udp_multicast"})
    (site.folder / "01_interface.yaml").unlink()
    with pytest.raises(BenchFirst, match="was not passed on the bench"):
        ladder.climb()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "answer", "words"),
    [
        ("pressed", False, "not by the emergency stop"),
        ("left_wheel_direction", False, "left wheel turns the wrong way: change `sign`"),
        ("right_wheel_scale", 50.0, "gear_ratio or counts_per_rev is 2.01 times too small"),
        ("signed_off", False, "not signed off"),
    ],
)
def test_what_a_person_sees_counts(site: Site, key: str, answer: Any, words: str) -> None:
    site.operator = ScriptedOperator(ANSWERS | {key: answer})
    last = climb(Ladder(site), "axes")[-1]
    assert not last.passed
    assert words in last.reason
    assert last.answers[key] == answer


def test_a_drive_that_doesnt_heed_the_emergency_stop(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    class Nobody(BenchOperator):
        def act(self, key: str, words: str, on_bench: Callable[[], None]) -> None:
            """Presses nothing."""

    site.operator = Nobody()
    last = climb(Ladder(site), "emergency_stop")[-1]
    assert (last.rung, last.passed) == ("emergency_stop", False)
    assert "still enabled: left wheel, right wheel" in last.reason


def slow_turner(site: Site) -> Site:
    """Return the site with a cart that drives and turns slower than a bring-up would."""
    drive = site.robot.drive.model_copy(update={"top_speed_m_s": 0.2, "top_turn_deg_s": 20.0})
    site.robot = site.robot.model_copy(update={"drive": drive})
    return site


def test_a_slow_robot_stops_from_the_speed_that_it_has(site: Site) -> None:
    facts = StopTestRung().climb(slow_turner(site))
    assert facts["speed_m_s"] == 0.2
    acceleration, period = site.robot.drive.acceleration_m_s2, site.robot.period_s
    assert facts["program_allowed_m"] == pytest.approx(0.2 * 2 * period + 0.2**2 / 2 / acceleration, abs=1e-4)


def test_a_robot_that_turns_slowly_is_calibrated(site: Site) -> None:
    site = slow_turner(site)
    site.folder.mkdir(parents=True)
    assert CalibrationRung().climb(site)["turn_deg"] == pytest.approx(360.0, abs=10.0)


@pytest.mark.parametrize(("key", "value"), [("way_m", 0.0), ("turn_deg", 0.0), ("turn_deg", -360.0)])
def test_a_calibration_by_no_motion_is_not_passed(site: Site, key: str, value: float) -> None:
    site.operator = ScriptedOperator({"clear": True, "way_m": 1.0, "turn_deg": 360.0} | {key: value})
    with pytest.raises(RungFailed, match=f"{key}: {value:g} was measured; needed: above 0"):
        CalibrationRung().climb(site)


class LargerWheels(BenchOperator):
    """Operator of a robot with wheels a quarter larger than in its file, and the tread of its file."""

    @override
    def number(self, key: str, question: str, truth: Callable[[], float]) -> float:
        return super().number(key, question, truth) * (1.25 if key in ("way_m", "turn_deg") else 1.0)


def test_the_tread_is_calibrated_for_the_calibrated_wheels(site: Site) -> None:
    site.folder.mkdir(parents=True)
    values = []
    for operator in (BenchOperator(), LargerWheels()):
        site.operator = operator
        CalibrationRung().climb(site)
        values.append(load(site.folder / CALIBRATION_FILE, Calibration).found)
    as_in_file, larger = values
    for key, ratio in (("drive.wheel_radius_m", 1.25), ("drive.tread_m", 1.0)):
        expected = ratio * as_in_file[key].value  # type: ignore[operator]
        assert larger[key].value == pytest.approx(expected, rel=2e-3)


def test_a_joint_without_end_has_no_limit_to_try(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    limited, text = '<joint name="joint_{}" type="revolute">', RobotFile.urdf_text

    def endless(robot: RobotFile) -> str:
        result = text(robot)
        for number in range(1, 7):
            words = limited.format(number)
            result = result.replace(words, words.replace("revolute", "continuous"))
        return result

    site.robot = load_robot("librarian")
    monkeypatch.setattr(RobotFile, "urdf_text", endless)
    facts = LimitsRung().climb(site)
    assert list(facts.values()) == [{"left_out": "it turns without end"}] * 6


def test_the_command(handcart: Callable[..., Said], tmp_path: Path) -> None:
    words = ("bringup", "cart", "--bench", "kinematic", "--folder", tmp_path / "b")
    report = json.loads(handcart(*words, "--json").out)
    assert (report["climbed"], report["next"]) == (["interface"], "identify")
    said = handcart(*words)
    assert said.status == 0
    assert "2 of 11 steps passed" in said.out
    assert "read_back: " in said.out
    assert handcart(*words, "--again", "interface", "--status").out.splitlines()[-1].startswith("0 of 11")
    assert len(list((tmp_path / "b" / "cart-bench").glob("before_*/01_interface.yaml"))) == 1
    wrong = handcart(*words, "--again", "interfase")
    assert (wrong.status, "did you mean 'interface'" in wrong.err) == (2, True)


def test_a_real_robot_is_refused_before_its_rehearsal(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("bringup", "cart", "--folder", tmp_path)
    assert said.status == 2
    assert "needed first: handcart bringup cart --bench kinematic --all" in said.err
    answers = tmp_path / "answers.yaml"
    answers.write_text("pressed: true\n")
    said = handcart("bringup", "cart", "--folder", tmp_path, "--answers", answers)
    assert (said.status, "a robot needs a person beside it" in said.err) == (2, True)


@pytest.mark.slow
def test_the_whole_ladder(handcart: Callable[..., Said], tmp_path: Path) -> None:
    """Up to the task; the calibration is a change to review."""
    robot = tmp_path / "cart"
    robot.mkdir()
    for path in CART.iterdir():
        if path.is_file():
            (robot / path.name).write_bytes(path.read_bytes())
    words = ("bringup", robot / "robot.yaml", "--bench", "kinematic", "--all", "--folder", tmp_path / "b")
    report = json.loads(handcart(*words, "--json").out)
    assert (report["climbed"], report["next"]) == (NAMES, None)
    review = next(item for item in report["tried"] if item["rung"] == "calibrate")["facts"]["review"]
    found = Path(review.removeprefix("handcart adopt "))
    said = handcart("adopt", found, "--write")
    assert said.status == 0
    assert "+  tread_m: 0.49" in said.out or "+  tread_m: 0.50" in said.out
    assert json.loads(handcart(*words, "--json").out)["climbed"] == NAMES  # adopting brings nothing down
