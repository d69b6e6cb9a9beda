"""The conformance kit: an honest backend passes, and the kit catches liars."""

from __future__ import annotations

import shutil
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import pytest

from handcart.backends.capabilities.range_sensor import Scan
from handcart.backends.description.robot_names import robot_path
from handcart.backends.simulation.sensors.simulated_range_sensor import SimulatedRangeSensor
from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.faults import fault
from handcart.evaluation.conformance.faults.fail_is_true import Batch, FaultTrial
from handcart.evaluation.conformance.faults.fault import (
    PRIMITIVE_FAULTS,
    Fault,
    FaultKind,
    all_sensors,
    faults_of,
    variant,
)
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.conformance.faults.forked import Died, Hung, forked
from handcart.evaluation.conformance.faults.rehearsal import DRIVE_MAP, TASKS_FOLDER, Rehearsal, Solo
from handcart.evaluation.conformance.faults.underway import AttemptEnding
from handcart.evaluation.conformance.kit import KitSetting, jobs_of, report_of, run_kit
from handcart.evaluation.conformance.planted.mutants import mutants, try_mutant
from handcart.evaluation.conformance.report import KitReport, Result
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.conformance.task_runs import Ran, compared
from handcart.evaluation.judging.survey import simulated_world
from handcart.files.errors import FileError
from handcart.networks.task.task_file import load_task
from handcart.primitives.outcomes import causes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.tasks.domain import Domain

BENCH = KitBench("kinematic")
SAMPLE = (
    "EchoesCommands",
    "EditsSnapshot",
    "QueuesCommands",
    "RaisesTolerance",
    "SwallowsFault",
    "WrongUnits",
)
"""Liars that are caught quickly; `handcart conformance --part mutants` plants all."""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["capabilities", "limits", "stop", "rates", "tag", "frames"])
def test_the_kinematic_backend_passes(name: str) -> None:
    finding = checks()[name](BENCH)
    assert finding.ok, finding.wrong
    assert not finding.skipped


def test_what_a_robot_lacks_is_left_out_with_the_reason() -> None:
    finding = checks()["joints"](KitBench("kinematic", robot="cart"))
    assert finding.skipped == "the robot has no arm"


LIARS_OF_NAVIGATION = {
    "DropsScans": "scans repeated or missing",
    "DelaysScans": "scans late 0.2",
    "MirrorsScans": "scans turn the other way than wheels",
    "StretchesTravel": "turn by wheels off 0.2",
    "SwapsWheels": "scans turn the other way than wheels",
}


def test_scans_and_wheels_of_an_honest_backend_agree() -> None:
    finding = checks()["navigation"](KitBench("kinematic", robot="cart"))
    assert finding.ok, finding.wrong
    assert not finding.skipped


@pytest.mark.slow
@pytest.mark.parametrize("name", LIARS_OF_NAVIGATION)
def test_a_liar_about_scans_or_wheels_is_caught(name: str) -> None:
    caught = try_mutant(name, KitBench("kinematic", robot="cart"))
    assert caught.by.startswith(f"navigation: {LIARS_OF_NAVIGATION[name]}")


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["mujoco", "pybullet"])
def test_navigation_checks_hold_with_physics(backend: str) -> None:
    bench = KitBench(backend, robot="cart")
    finding = checks()["navigation"](bench)
    assert finding.ok, finding.wrong
    assert try_mutant("SwapsWheels", bench).by


@pytest.fixture
def without_noise(tmp_path: Path) -> KitBench:
    """A cart whose simulation has no errors."""
    folder = Path(shutil.copytree(robot_path("cart").parent, tmp_path / "cart"))
    text = (folder / "robot.yaml").read_text(encoding="utf-8")
    start, end = text.index("errors:"), text.index("tolerance:")
    (folder / "robot.yaml").write_text(
        f"{text[:start]}errors: {{none: true}}\n{text[end:]}", encoding="utf-8"
    )
    return KitBench("kinematic", str(folder / "robot.yaml"))


@pytest.mark.parametrize("name", ["rates", "seed"])
def test_kit_accepts_a_simulation_without_noise(without_noise: KitBench, name: str) -> None:
    finding = checks()[name](without_noise)
    assert finding.wrong == []
    assert any(words.startswith("without noise: ") for words in finding.measured)


def test_kit_rejects_a_stale_lidar_without_noise(
    without_noise: KitBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[Scan] = []
    scan = SimulatedRangeSensor.scan

    def stale(sensor: SimulatedRangeSensor) -> Scan:
        kept.append(kept[0] if kept else scan(sensor))
        return kept[0]

    monkeypatch.setattr(SimulatedRangeSensor, "scan", stale)
    (wrong,) = checks()["rates"](without_noise).wrong
    assert wrong == "the same at rest and after the base drove: ['range sensor scan']"


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLE)
def test_a_liar_is_caught(name: str) -> None:
    caught = try_mutant(name, BENCH)
    assert caught.by
    assert not caught.skipped


@pytest.mark.slow
@pytest.mark.parametrize(("name", "liar"), [("imu", "TurnsOtherWay"), ("gps", "FixInMillimetres")])
def test_gyros_and_receivers_are_checked_and_their_liars_caught(name: str, liar: str) -> None:
    car = KitBench("kinematic", robot="el_verde")
    finding = checks()[name](car)
    assert finding.ok, finding.wrong
    assert not finding.skipped
    assert try_mutant(liar, car).by.startswith(f"{name}: ")
    assert try_mutant(liar, BENCH).skipped == f"the robot has no {name}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["base", "joints", "one period", "imu", "gps"])
def test_a_car_passes_too(name: str) -> None:
    """It turns only while it drives, and its first joint stands at its limit."""
    finding = checks()[name](KitBench("kinematic", robot="el_verde"))
    assert finding.ok, finding.wrong


def test_there_are_33_mutants_and_each_has_its_own_lie() -> None:
    assert len(mutants()) == 33
    assert len({mutant.lie for mutant in mutants().values()}) == 33


@pytest.mark.slow
def test_a_robot_with_an_indoor_positioning() -> None:
    bench = KitBench("kinematic", robot="atrv")
    for name in ("capabilities", "positioning", "joints", "frames"):
        finding = checks()[name](bench)
        assert finding.ok, finding.wrong
        assert not finding.skipped
    assert try_mutant("Undelayed", bench).by.startswith("positioning: off ")
    assert try_mutant("Undelayed", BENCH).skipped == "the robot has no positioning"
    assert KitSetting("kinematic", "atrv").tried() == ["DIVIDE", "MOVE_TO", "REACH", "TRACK"]


@pytest.mark.slow
def test_an_honest_primitive_is_true_whatever_goes_wrong() -> None:
    trials = Batch(Solo(BENCH, Reach()), 0, 1)()
    assert len(trials) == len(PRIMITIVE_FAULTS)
    assert [str(trial) for trial in trials if trial.ending.wrong] == []
    assert {trial.ending.outcome for trial in trials} >= {"Success", "Fail"}


def test_a_rehearsal_has_every_primitive_of_the_task() -> None:
    rehearsal = Rehearsal(TASKS_FOLDER / "return_book" / "task.yaml", "kinematic")
    assert {action.do for action in rehearsal.actions()} == {
        action.do for action in load_task(TASKS_FOLDER / "return_book" / "task.yaml").network.actions
    }


@pytest.mark.slow
def test_what_is_tried_depends_on_what_the_robot_can_do() -> None:
    with_arm, without = KitSetting("kinematic"), KitSetting("kinematic", robot="cart")
    assert {"REACH", "MOVE_TO", "RELEASE"} <= set(with_arm.tried())
    assert without.tried() == ["EXPLORE", "LOCATE", "MODIFY", "MOVE_TO", "REACH"]
    others = [DRIVE_MAP.with_name(name) for name in ("locate.yaml", "explore.yaml")]
    assert [found.task for found in without.rehearsals] == [DRIVE_MAP, *others]


def test_full_mode_injects_over_2500_faults_on_kinematic() -> None:
    batches = KitSetting("kinematic").batches()
    assert {batch.instants for batch in batches} == {40}
    moving = {batch.action for batch in batches} - {3, 9}  # MODIFY takes a few periods
    assert len(moving) * 40 * len(PRIMITIVE_FAULTS) >= 2500


def test_each_kind_of_fault_goes_through_its_ways() -> None:
    every = all_sensors()
    assert {variant(FaultKind.STALE, number).sensor for number in range(len(every))} == set(every)
    assert {"wheels", "joints", "width", "positioning", "imu", "gps"} < set(all_sensors())
    assert len({variant(FaultKind.SLIP, number) for number in range(8)}) == 4
    assert str(Fault(FaultKind.NAN, "joints", 10)) == "NaN joints for 10 periods"


def test_a_copy_of_the_process_may_hang_or_die() -> None:
    assert forked(lambda: 3, int, 10.0) == 3
    with pytest.raises(Died, match="ZeroDivisionError"):
        forked(lambda: 1 // 0, int, 10.0)

    def hang() -> None:
        while True:
            pass

    with pytest.raises(Hung):
        forked(hang, type(None), 0.3)


def test_a_report_tells_what_is_wrong() -> None:
    wrong = CheckResult("limits", "what is beyond is refused", ["drive(nan, 0) is taken"])
    untrue = AttemptEnding(
        "Fail", "it was only to be tried", 9, wrong=("Fail, but base mm 60.00 (at most 45.00)",)
    )
    trial = FaultTrial("REACH", 0, 7, "cancel", "cancel", untrue)
    report = KitReport.of("mine", "librarian", True, [wrong, [trial]])
    text = "\n".join(report.lines())
    assert not report.ok
    assert "WRONG limits" in text
    assert "drive(nan, 0) is taken" in text
    assert "VIOLATION  REACH, period 7, cancel: Fail: Fail, but base mm 60.00" in text
    assert "1 checks, 1 wrong; 1 faults, 1 violations" in text
    assert report.as_dict()["faults"]["violations"][0]["period"] == 7


def ran(backend: str, seed: int, outcome: str = "Success", errors: bool = True, *untrue: str) -> Ran:
    return Ran("return_book", backend, seed, errors, outcome, "returned", "", untrue)


def test_a_task_must_end_the_same_way_without_errors() -> None:
    runs = [ran("mine", 0, "Fail", False), ran("kinematic", 0, "Success", False)]
    (finding,) = compared(runs, "mine")
    assert finding.wrong == ["mine: Fail in returned; kinematic: Success in returned"]
    assert compared([ran("mine", 0, errors=False), runs[1]], "mine")[0].ok


@pytest.mark.parametrize(("fails", "ok"), [(0, True), (5, True), (6, False), (50, False)])
def test_success_rates_that_differ_beyond_chance_are_wrong(fails: int, ok: bool) -> None:
    runs = [ran("kinematic", seed) for seed in range(50)]
    runs += [ran("mine", seed, "Fail" if seed < fails else "Success") for seed in range(50)]
    (finding,) = compared(runs, "mine")
    assert finding.ok == ok


def test_an_untrue_outcome_is_wrong_at_any_rate() -> None:
    runs = [ran("kinematic", 0), ran("mine", 0, "Success", True, "the book lies on the floor")]
    (finding,) = compared(runs, "mine")
    assert finding.wrong == ["seed 0 on mine: the book lies on the floor"]


def test_whole_tasks_are_run_on_both_backends() -> None:
    names = [str(run) for run in KitSetting("pybullet", seeds=2).task_runs()]
    assert "return_book on pybullet without errors" in names
    assert "drive_map on kinematic with seed 1" in names
    assert {name.split(" on ")[0] for name in names} == {
        "drive_map",
        "fetch_and_carry",
        "return_book",
        "return_books",
    }
    assert len(names) == 8 * 2 * 3
    assert "tasks" not in KitSetting("pybullet", quick=True).chosen_parts


@pytest.mark.slow
def test_a_shipped_task_for_real(tmp_path: Path) -> None:
    """Drive to one of its places."""
    task = Path(shutil.copytree(DRIVE_MAP.parent, tmp_path / "drive_map")) / DRIVE_MAP.name
    text = task.read_text(encoding="utf-8")
    assert text.count("tour: {all: places}") == 1
    task.write_text(text.replace("tour: {all: places}", "tour: [desk]"), encoding="utf-8")
    setting = KitSetting("kinematic", "cart", parts=("tasks",), seeds=1, own_tasks=[task])
    report = run_kit(setting, 1)
    assert report.ok
    assert sorted(words for task in report.tasks for words in task.measured) == [
        "kinematic: Success 1 of 1",
        "kinematic: Success in toured",
    ]


@pytest.mark.slow
def test_pybullet_passes_where_physics_matters() -> None:
    pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")
    bench = KitBench("pybullet")
    for name in ("one period", "stop", "frames"):
        finding = checks()[name](bench)
        assert finding.ok, finding.wrong


def test_a_primitive_of_somebody_else_is_found_by_its_name() -> None:
    jobs = jobs_of(KitSetting("kinematic", quick=True, parts=("faults",), primitives=("REACH",)))
    assert len(jobs) == 1


@pytest.mark.slow
def test_the_fixture_tries_a_backend_and_faults_lead_to_their_causes(conformance: Any) -> None:
    report = conformance("kinematic", robot="cart", parts=("faults",), primitives=("REACH",), instants=1)
    assert report.ok
    assert report.injected == len(PRIMITIVE_FAULTS)
    judged = {trial.kind: trial for trial in report.judged_causes}
    assert judged["cancel"].ending.cause == causes.CANCELLED.name
    assert judged["time-out"].ending.cause == causes.TIME_OUT.name
    assert report.wrong_causes == []


@pytest.mark.slow
def test_a_robot_that_is_not_there_is_told_at_once() -> None:
    with pytest.raises(FileError, match=r"/nowhere/robot\.yaml:1:1: the file does not exist"):
        run_kit(KitSetting("kinematic", "/nowhere/robot.yaml", True, ("mutants",)), 1)


def push(world: Any) -> None:
    world.base = world.base.compose(Pose2(0.2, 0.0, 0.0))


PUSH = Fault(FaultKind.WORLD, "push", act=push)


def test_a_domain_declares_what_may_happen_in_its_world(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is tried in the domain's primitives alone, beside what is tried in any."""
    domain = Domain("lamps", {"REACH": "nowhere:Reach"}, faults="lamps:FAULTS")
    monkeypatch.setattr(fault, "domains", lambda: (domain,))
    monkeypatch.setattr(fault, "imported", {"lamps:FAULTS": [PUSH]}.__getitem__)
    assert faults_of("MOVE_TO") == ()
    batch = Batch(Solo(BENCH, Reach()), 0, 1)
    assert [item.kind for item in batch.faults("REACH", 0, all_sensors())] == [
        *PRIMITIVE_FAULTS,
        FaultKind.WORLD,
    ]
    assert [item.kind for item in batch.faults("STAND", 0, all_sensors())] == [*PRIMITIVE_FAULTS]


def test_a_fault_in_the_world_happens_for_its_periods() -> None:
    with BENCH.rig() as rig:
        backend, scene = FaultyBackend(rig.backend), simulated_world(rig.backend)
        assert scene is not None
        before = scene.base
        backend.inject(PUSH)
        for _ in range(3):
            backend.step()
        assert scene.base.distance(before) == pytest.approx(0.2, abs=0.01)
        assert backend.bitten == 1


@pytest.mark.slow
def test_a_kit_that_is_cut_off_keeps_the_results_until_then() -> None:
    setting, results = KitSetting("kinematic", "cart", True, ("checks",)), dict[int, Result]()

    def cut_off(done: int, count: int) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_kit(setting, 1, cut_off, results)
    assert active_children() == []
    report = report_of(setting, results)
    assert 1 <= len(report.checks) == len(results) < len(jobs_of(setting))
    assert report.ok
