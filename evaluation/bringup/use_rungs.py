"""Steps that calibrate the robot, and put it to use."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.localization.lidar import Lidar
from handcart.evaluation.trials.rig import LIBRARY_FOLDER, Rig
from handcart.evaluation.trials.running import run_task
from handcart.files.whole_file import write_whole
from handcart.networks.graph.planner import NoWay, Planner
from handcart.networks.runs.calibration import CALIBRATION_FILE, Calibration, rounded
from handcart.networks.runs.robot_claim import claimed
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import prepare
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.primitives.outcomes.outcome import Success

from .jog import HAND_SPEED
from .rung import Facts, Rung, RungFailed
from .site import RobotSite, Site

CAMERA_TASK = LIBRARY_FOLDER.parent / "calibrate_camera" / "task.yaml"
TAPE_ACCURACY_M = 0.002
"""Accuracy of a tape measure, in [m]."""
PROTRACTOR_ACCURACY_RAD = math.radians(1.0)
WAY, TURNS = 1.0, 1
"""Motions of the base, in [m] and whole turns."""
SCAN_COUNT = 100
"""Number of scans from which the spread of the ranges is measured."""
MIN_SCAN_COUNT = 20
SCANNING_TIMEOUT_S = 30.0
RETURNS_SHARE = 0.8  # of them, in which a beam returns, to be measured
_SETTLE = 1.0  # [s]


class CalibrationRung(Rung[Site]):
    """Bring-up step that calibrates odometry and lidar, and proposes a change of the robot's file."""

    name = "calibrate"
    summary = "wheel radius, tread and range sensor are measured; `handcart adopt` shows what that changes"

    @override
    def climb(self, site: Site) -> Facts:
        found: dict[str, Calibrated] = {}
        facts: Facts = {}
        with site.backend() as backend:
            if not site.confirm("clear", f"Is the way clear? The base drives {WAY} m and turns on the spot."):
                raise RungFailed("the way wasn't clear")
            stretch = self._radius(site, backend, found, facts)
            self._tread(site, backend, stretch, found, facts)
            _measure_ranges(site, backend, found, facts)
        facts["review"] = f"handcart adopt {_write(site, found)}"
        return facts

    def _radius(self, site: Site, backend: CanBackend, found: dict[str, Calibrated], facts: Facts) -> float:
        """Calibrate the wheels' radius; return the ratio of the true way to that of the encoders."""
        before = _true_pose(backend)
        rolled = _drive(site, backend, HAND_SPEED, 0.0, lambda left, right: (left + right) / 2 >= WAY)
        way = (rolled[0] + rolled[1]) / 2
        truth = float(np.hypot(*(_true_pose(backend)[:2] - before[:2])))
        measured = _positive(site, "way_m", "Distance that the base drove, by tape [m]?", truth)
        radius = site.robot.drive.wheel_radius_m * measured / way
        found["drive.wheel_radius_m"] = Calibrated(radius, radius * TAPE_ACCURACY_M / way)
        facts |= {"way_by_encoder_m": round(way, 4), "way_m": round(measured, 4)}
        return measured / way

    def _tread(
        self, site: Site, backend: CanBackend, stretch: float, found: dict[str, Calibrated], facts: Facts
    ) -> None:
        """Calibrate the tread for wheels of the calibrated radius, whose way is longer by `stretch`."""
        drive = site.robot.drive
        turn = min(0.5, HAND_SPEED / site.robot.footprint_radius_m)
        goal = 2.0 * math.pi * TURNS * drive.tread_m / 2
        before = _true_pose(backend)[2]
        left, right = _drive(site, backend, 0.0, turn, lambda left, right: (right - left) / 2 >= goal)
        by_encoder = (right - left) / drive.tread_m
        true = before + by_encoder + _wrapped(_true_pose(backend)[2] - before - by_encoder)
        question = "Angle that it turned to the left, by marks on the floor [deg]?"
        measured = math.radians(_positive(site, "turn_deg", question, math.degrees(true - before)))
        tread = stretch * (right - left) / measured
        found["drive.tread_m"] = Calibrated(tread, tread * PROTRACTOR_ACCURACY_RAD / measured)
        facts |= {"turn_by_encoder_deg": round(math.degrees(by_encoder), 2)}
        facts |= {"turn_deg": round(math.degrees(measured), 2)}


def _measure_ranges(site: RobotSite, backend: Backend, found: dict[str, Calibrated], facts: Facts) -> None:
    """Measure the spread of the ranges, and compare one of them with a tape."""
    found_sensor = backend.get(RangeSensor)  # type: ignore[type-abstract]
    if found_sensor is None:
        facts["range_sensor"] = "none"
        return
    sensor = Lidar(found_sensor, site.robot)
    ranges = np.array([scan.ranges for scan in _new_scans(sensor, backend)])
    ranges[~np.isfinite(ranges)] = np.nan
    seen = np.isfinite(ranges).mean(axis=0) >= RETURNS_SHARE
    if not seen.any():
        raise RungFailed(sensor.silence or "the range sensor sees nothing: no beam returns steadily")
    sigma = 1e3 * float(np.median(np.nanstd(ranges[:, seen], axis=0, ddof=1)))
    found["range_sensor.sigma_mm"] = Calibrated(sigma, sigma / math.sqrt(2 * (len(ranges) - 1)))
    ahead = int(np.argmin(np.abs(sensor.scan().angles)))
    nearest = int(np.flatnonzero(seen)[np.argmin(np.abs(np.flatnonzero(seen) - ahead))])
    reading = float(np.nanmean(ranges[:, nearest]))
    angle = math.degrees(float(sensor.scan().angles[nearest]))
    question = f"How far is it from the sensor at {angle:.0f} deg, by tape [m]?"
    measured = site.number("range_m", question, reading)
    facts |= {
        "range_sigma_mm": round(sigma, 2),
        "scans": len(ranges),
        "range_m": round(reading, 4),
        "range_by_tape_m": measured,
    }
    allowed = max(0.02, 3e-3 * sigma)
    if abs(measured - reading) > allowed:
        wrong = f"the range sensor tells {reading:.3f} m, the tape {measured:.3f} m"
        raise RungFailed(f"{wrong}; allowed: {allowed:.3f} m apart")


def _new_scans(sensor: Lidar, backend: Backend) -> list[Scan]:
    """Return `SCAN_COUNT` scans of a robot at rest, each once although a slow lidar repeats its scans.

    Raises:
        RungFailed: fewer than `MIN_SCAN_COUNT` came within `SCANNING_TIMEOUT_S`.
    """
    scans = [sensor.scan()]
    for _ in range(round(SCANNING_TIMEOUT_S / backend.period)):
        backend.step()
        if sensor.scan() is not scans[-1]:
            scans.append(sensor.scan())
        if len(scans) > SCAN_COUNT:
            break
    if len(scans) <= MIN_SCAN_COUNT:
        came = f"{len(scans) - 1} new scans came within {SCANNING_TIMEOUT_S:g} s"
        raise RungFailed(f"the range sensor: {came}; needed: {MIN_SCAN_COUNT}")
    return scans[1:]


def _drive(
    site: Site, backend: CanBackend, speed: float, turn: float, there: Callable[[float, float], bool]
) -> tuple[float, float]:
    """Drive until `there` accepts the wheels' travel, and stop; return the travel, left and right, in [m]."""
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None
    begun, top_turn = base.wheel_travel(), math.radians(site.robot.drive.top_turn_deg_s)
    rolled = (0.0, 0.0)
    with site.operator.hold("hold the space bar: the base moves") as held:
        while not there(*rolled):
            if not held():
                backend.stop()
                raise RungFailed("the key was let go before the base was there")
            base.drive(min(speed, site.robot.drive.top_speed_m_s), min(turn, top_turn))
            backend.step()
            now = base.wheel_travel()
            rolled = now.left - begun.left, now.right - begun.right
    backend.stop()
    for _ in range(round(_SETTLE / backend.period)):
        backend.step()
    now = base.wheel_travel()
    return now.left - begun.left, now.right - begun.right


def _positive(site: RobotSite, key: str, question: str, truth: float) -> float:
    """Ask the operator for a value above 0; raise `RungFailed` for any other."""
    measured = site.number(key, question, truth)
    if not measured > 0.0:
        raise RungFailed(f"{key}: {measured:g} was measured; needed: above 0, the wheels have turned")
    return measured


def _true_pose(backend: CanBackend) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the true pose (3,) on a bench, x, y in [m] and heading in [rad]; zero for a real robot."""
    truth = backend.ground_truth()
    return np.zeros(3) if truth is None else np.array([*truth.base])


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


class RangesRung(Rung[RobotSite]):
    """Bring-up step that measures the spread of the lidar's ranges, and checks one range by a tape
    measure.
    """

    name = "range_sensor"
    summary = "the lidar's spread, and one range by tape; `handcart adopt` shows what that changes"
    moves = False

    @override
    def left_out(self, site: RobotSite) -> str:
        return "" if site.robot.range_sensor is not None else "the robot has no lidar"

    @override
    def climb(self, site: RobotSite) -> Facts:
        found: dict[str, Calibrated] = {}
        facts: Facts = {}
        with site.backend() as backend:
            _measure_ranges(site, backend, found, facts)
        return {**facts, "review": f"handcart adopt {_write(site, found)}"}


def _write(site: RobotSite, found: dict[str, Calibrated]) -> Path:
    """Write the values that a calibration found next to the records; return the file."""
    file = site.folder / CALIBRATION_FILE
    kind = site.backend_name + (f" --bench {site.bench}" if site.bench else "")
    calibration = Calibration(
        format="handcart-calibration/1", robot=site.name, backend=kind, found=rounded(found)
    )
    write_whole(file, calibration.text())
    return file


class CameraRung(Rung[RobotSite]):
    """Bring-up step that calibrates the camera and its pose on the hand with a calibration board."""

    name = "camera"
    summary = "the camera and where it sits on the hand, by a board; `handcart adopt` shows what that changes"

    @override
    def left_out(self, site: RobotSite) -> str:
        if site.robot.hand_camera is None:
            return "the robot has no camera on an arm"
        if site.bench and not site.camera_on_bench:
            return "on the bench only with --camera: it takes minutes"
        return ""

    @override
    def climb(self, site: RobotSite) -> Facts:
        question = f"Is the board where {CAMERA_TASK.parent}/building.yaml says, and the arm free?"
        if not site.confirm("board", question):
            raise RungFailed("the board isn't there")
        facts = _run(site, CAMERA_TASK)
        return {**facts, "review": f"handcart adopt {facts['run_dir']}"}


class PrimitiveRung(Rung[RobotSite]):
    """Bring-up step that runs only the first primitive (single action) of the task."""

    name = "primitive"
    summary = "the first primitive of the task ends in Success"

    @override
    def climb(self, site: RobotSite) -> Facts:
        if not site.confirm("free", "Is the route free, and is the robot's reach clear of people?"):
            raise RungFailed("it wasn't free")
        settings = {"robot": site.name}
        with prepare(site.task, site.backend_name, settings, bench=site.bench or None) as prepared:
            network = prepared.task.network
            plan = Planner(network).plan(network.start)
            if isinstance(plan, NoWay) or plan.actions[0].binding is None:
                raise RungFailed(f"{site.task} has no first primitive")
            first = plan.actions[0]
            assert first.binding is not None
            rig = Rig(prepared.robot, prepared.model, prepared.backend)
            with claimed(prepared.backend):
                outcome = rig.do(first.binding.make(prepared.model))
        if not isinstance(outcome, Success):
            raise RungFailed(f"{first.do}: {type(outcome).__name__}, {outcome.reason}")
        return {"primitive": str(first), "outcome": "Success", "sim_time_s": round(prepared.robot.time, 2)}


class TaskRung(Rung[RobotSite]):
    """Bring-up step that runs the complete task for which the robot is brought up."""

    name = "task"
    summary = "the task ends in Success"

    @override
    def climb(self, site: RobotSite) -> Facts:
        if not site.confirm("ready", f"Is {site.task} ready, and the robot's reach clear of people?"):
            raise RungFailed("it isn't ready")
        return _run(site, site.task)


def _run(site: RobotSite, task: Path) -> Facts:
    """Run a task to its Success; raises `RungFailed`."""
    summary, _ = run_task(
        task,
        site.folder / "runs",
        RunOptions(site.backend_name, {"robot": site.name}, draw=True, bench=site.bench or None),
    )
    if summary["outcome"] != "Success":
        explained = f"handcart explain {summary['run_dir']}"
        raise RungFailed(f"{task}: {summary['outcome']}, {summary['reason']}; {explained}")
    return {key: summary[key] for key in ("outcome", "actions", "fails", "sim_time_s", "run_dir")}
