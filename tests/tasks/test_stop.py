"""A stop in any primitive: it leaves within three control periods, and all rests within the stated ramp."""

from __future__ import annotations

import random
import signal
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.robot import MAX_STOP_PERIODS, Robot
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.networks.events.events import Event, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.runs.flight_recorder import load_readings
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared

TASK = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml"
MOTION = 1e-3  # [m], [rad]: less between two periods is noise
PRIMITIVES = {"RECOGNIZE", "PICK_UP", "MOVE_TO", "SEARCH", "APPROACH", "INSERT", "RELEASE"}


class Impatient(RunObserver):
    """Presses Ctrl-C repeatedly, some time after the `number`-th of the actions has begun.

    Each earlier action was stopped and started again, so it is counted twice.
    """

    def __init__(self, after: float, number: int) -> None:
        self.due: float | None = None
        self.after, self.number = after, number

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        self.robot = prepared.robot

    def event(self, event: Event) -> None:
        if isinstance(event, Started) and event.number >= 2 * self.number - 1 and self.due is None:
            self.due = event.time + self.after

    def period(self, robot: Robot) -> None:
        if self.due is not None and robot.time >= self.due:
            signal.raise_signal(signal.SIGINT)


def last_motion(folder: Path, since: float) -> float:
    """When a wheel, a joint or a finger moved last, in [s] of the robot's time."""
    readings = load_readings(folder / "evidence" / "end_readings.npz")
    parts = ("wheel_left_m", "wheel_right_m", "joints_rad", "grip_width_m")
    columns = np.column_stack([readings[name] for name in parts])
    moving = np.abs(np.diff(columns, axis=0)).max(axis=1) > MOTION
    times = readings["time_s"][1:][moving]
    return float(times[-1]) if len(times) else since


@pytest.mark.slow
def test_stopped_in_every_primitive_of_return_book(tmp_path: Path) -> None:
    """K3: each run is stopped in its next action, and resumed."""
    rng, period = random.Random(5), load_robot("librarian").period_s
    folder, stopped, waits = tmp_path / "return_book-0", set(), []
    for number in range(1, 9):
        operator = Impatient(rng.uniform(0.2, 2.5), number)
        if number == 1:
            _, status = run_task(TASK, tmp_path, RunOptions(observers=(operator,), checkpoints=True))
        else:
            _, status = resume_task(folder, None, RunOptions(observers=(operator,)))
        assert status == 130
        ramp = _stopping_ramp(operator.robot)
        *_, start, stop, end = (
            record
            for record in read_journal(folder / "journal.jsonl").records
            if record["kind"] in ("START", "STOP", "END")
        )
        assert (stop["kind"], end["outcome"]) == ("STOP", "Cancelled")
        stopped.add(start["action"]["do"])
        waits.append((stop["sent_s"] - stop["asked_s"]) / period)
        assert last_motion(folder, stop["sent_s"]) <= stop["sent_s"] + ramp + period
    assert stopped == PRIMITIVES
    assert max(waits) <= MAX_STOP_PERIODS + 1e-6


def _stopping_ramp(robot: Robot) -> float:
    """The longest that anything moves on after the stop command has left, in [s]: from top speed."""
    drive = robot.spec.drive
    base = drive.top_speed_m_s / drive.acceleration_m_s2
    turn = drive.top_turn_deg_s / drive.turn_acceleration_deg_s2
    ramps = robot.spec.joint_speeds() / robot.spec.joint_accelerations()
    return max([base, turn, *map(float, ramps)])
