"""How far a tool is off its seam, the base standing or moving.

python -m benchmarks.seam.tracking [RUNS] [--plot FILE] [--physics]

Median over the runs (40) of each one's largest error, as Shin et al. (2005), figure 5, compares them.
"Standing" is the task track_seam, on the kinematic backend or in physics; its error is the tool's distance
from the seam.
"Moving" drives the base along the seam; the error is the distance from where the tool should be at that time.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.seam.moving_tracking import Feedback, MovingTracking
from handcart.backends.description.robot_loading import load_robot
from handcart.evaluation.seam.placement_plots import draw_tracking_errors
from handcart.evaluation.seam.seam_survey import SeamSurvey
from handcart.evaluation.truth.judge import Judge
from handcart.networks.run_options import RunOptions
from handcart.networks.runs.run import execute
from handcart.networks.task.preparing import prepare
from handcart.primitives.seam.seam_file import load_seam

TASK = Path(__file__).parent.parent.parent / "tasks" / "track_seam"
MOVING = {
    "moving, open loop": (None, "20 to 32"),
    "moving, feedback: arm 5 Hz, 20 ms late, 50 readings/s": (Feedback(5.0, 0.02, 50.0), "<= 2.7"),
    "moving, feedback: arm 20 Hz, 10 ms late, 100 readings/s": (Feedback(20.0, 0.01, 100.0), ""),
    "moving, feedback: arm 20 Hz, 5 ms late, 200 readings/s": (Feedback(20.0, 0.005, 200.0), "<= 1.5"),
    "the same, readings not carried on": (Feedback(20.0, 0.005, 200.0, ahead=False), ""),
}

Run = tuple[NDArray[np.float64], NDArray[np.float64]]


class Row(NamedTuple):
    """A line of the table, in [mm]."""

    name: str
    maxima: list[float]
    rms: list[float]
    speed_use: float
    wanted: str

    def __str__(self) -> str:
        maximum, late = np.median(self.maxima), np.percentile(self.maxima, 95)
        rms, use = float(np.median(self.rms)), self.speed_use
        return f"{self.name:58}{rms:7.2f}{maximum:9.2f}{late:9.2f}{use:8.2f}   {self.wanted}"


def standing(count: int, backend: str | None = None) -> tuple[Row, Run]:
    """Runs of the task, on the kinematic backend or another."""
    maxima, rms, last, use = [], [], (np.zeros(1), np.zeros(1)), 0.0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(count):
            seam = _surveyed(Path(folder) / str(seed), seed, backend)
            figures = seam.figures()
            maxima.append(figures["tracking_error_mm_max"])
            rms.append(figures["tracking_error_mm_rms"])
            use = max(use, *(float(each.speed.max()) for each in seam.uses()))
            last = _in_a_row(seam.errors())
    return Row(f"standing, {backend}" if backend else "standing", maxima, rms, use, "<= 1"), last


def _surveyed(folder: Path, seed: int, backend: str | None) -> SeamSurvey:
    """What the ground truth says of a run."""
    with prepare(TASK / "task.yaml", backend, seed=seed) as prepared:
        judge = Judge(prepared)
        end = execute(prepared, folder, RunOptions(observers=(judge,))).end
        assert end.outcome == "Success", end.reason
    seam = judge.surveys.of(SeamSurvey)
    assert seam is not None, "the task has one"
    return seam


def _in_a_row(stretches: list[Run]) -> Run:
    """One after the other, without the time between them."""
    errors = np.concatenate([off for _, off in stretches])
    period = stretches[0][0][1] - stretches[0][0][0]
    return period * np.arange(len(errors)), errors


def moving(name: str, count: int) -> tuple[Row, Run]:
    """Runs beside the seam."""
    feedback, wanted = MOVING[name]
    tracking = MovingTracking(load_robot("atrv"), load_seam(TASK / "seam.csv"))
    runs = [tracking.run(seed, feedback) for seed in range(count)]
    maxima = [1e3 * float(run.errors.max()) for run in runs]
    rms = [1e3 * float(np.sqrt(np.mean(run.errors**2))) for run in runs]
    row = Row(name, maxima, rms, max(run.speed_use for run in runs), wanted)
    return row, (runs[0].times, runs[0].errors)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="?", type=int, default=40)
    parser.add_argument("--plot", type=Path, help="draw one run of each, as figure 5")
    parser.add_argument("--physics", action="store_true", help="the standing runs in PyBullet alone")
    given = parser.parse_args()
    print(
        f"{'error in mm, ' + str(given.runs) + ' runs':58}{'rms':>7}{'max':>9}{'p95':>9}{'speed':>8}   wanted"
    )
    if given.physics:
        print(standing(given.runs, "pybullet")[0])
        return
    shown = []
    for name in MOVING:
        row, run = moving(name, given.runs)
        print(row, flush=True)
        shown.append((name, *run))
    row, run = standing(given.runs)
    print(row, flush=True)
    shown.insert(0, (row.name, *run))
    if given.plot:
        draw_tracking_errors([shown[index] for index in (0, 1, 4)], given.plot)


if __name__ == "__main__":
    main()
