"""Measure the distance of a tool from its seam, with a standing and with a driving base.

python -m benchmarks.seam.tracking [RUNS] [--backend NAME] [--plot FILE]

RUNS (40) seeded runs each: the task track_seam, and the same with a base that drives. "Open loop" is the
latter with an arm that does not correct the base's deviations, as Shin et al. (2005), figure 5, compare
them; TRACK's own outcome is ignored there. All errors are those of the robot's file: slipping wheels with
other radii, positioning, arm. The error is the tool's distance from the seam, by ground truth.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
from typing_extensions import override

from handcart.evaluation.judging.judge import Judge
from handcart.evaluation.seam.seam_survey import SeamSurvey
from handcart.evaluation.seam.tracking_plot import draw_tracking_errors
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import prepare
from handcart.primitives.seam import track
from handcart.primitives.seam.driven_base import DrivenBase
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

TASKS_FOLDER = Path(__file__).parent.parent.parent / "tasks" / "track_seam"
DRIVING_TASK = "driving.yaml"

Run = tuple[FloatArray, FloatArray]


class OpenLoop(DrivenBase):
    """The arm moves as if the base were where it should be."""

    @override
    def base_at_end(self, index: int, speed: float, turn_rate: float) -> Pose2:
        x, y = self.ahead(index + 1)[0]
        return Pose2(float(x), float(y), self.heading)


class Row(NamedTuple):
    """A line of the table, in [mm]."""

    name: str
    maxima: list[float]
    rms: list[float]
    speed_use: float
    untrue: int

    def __str__(self) -> str:
        maximum, late, most = np.median(self.maxima), np.percentile(self.maxima, 95), max(self.maxima)
        rms, use = float(np.median(self.rms)), self.speed_use
        return f"{self.name:28}{rms:7.2f}{maximum:9.2f}{late:9.2f}{most:9.2f}{use:8.2f}{self.untrue:9}"


@contextmanager
def open_loop() -> Iterator[None]:
    """TRACK doesn't feed back where the base is, nor mind where the tool is."""
    with ExitStack() as changed:
        changed.enter_context(patch.object(track, "DrivenBase", OpenLoop))
        changed.enter_context(patch.object(track, "MOST_OFF", math.inf))
        yield


def runs(name: str, task: Path, count: int, backend: str | None) -> tuple[Row, Run]:
    """Seeded runs of a task."""
    maxima, rms, last, use, untrue = [], [], (np.zeros(1), np.zeros(1)), 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(count):
            seam, wrong = _surveyed(task, Path(folder) / str(seed), seed, backend)
            figures = seam.figures()
            maxima.append(figures["tracking_error_mm_max"])
            rms.append(figures["tracking_error_mm_rms"])
            use = max(use, *(float(limit_use.speed.max()) for limit_use in seam.uses()))
            untrue += bool(wrong)
            last = _in_a_row(seam.errors())
    return Row(name, maxima, rms, use, untrue), last


def _surveyed(task: Path, folder: Path, seed: int, backend: str | None) -> tuple[SeamSurvey, list[str]]:
    """Return the survey of a run by ground truth, and the untrue outcomes."""
    with prepare(task, backend, seed=seed) as prepared:
        judge = Judge(prepared)
        end = execute(prepared, folder, RunOptions(observers=(judge,))).end
        assert end.outcome == "Success", end.reason
        untrue = judge.figures(end)["untrue"]
    seam = judge.surveys.of(SeamSurvey)
    assert seam is not None, "the task has one"
    return seam, untrue


def _in_a_row(stretches: list[Run]) -> Run:
    """One after the other, without the time between them."""
    errors = np.concatenate([off for _, off in stretches])
    period = stretches[0][0][1] - stretches[0][0][0]
    return period * np.arange(len(errors)), errors


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="?", type=int, default=40)
    parser.add_argument("--backend", help="another than kinematic")
    parser.add_argument("--plot", type=Path, help="draw one run of each, as figure 5")
    given = parser.parse_args()
    head = f"{'mm, ' + str(given.runs) + ' runs':28}{'rms':>7}{'max':>9}{'p95':>9}{'worst':>9}"
    print(f"{head}{'speed':>8}{'untrue':>9}")
    shown = []
    for name, file in (
        ("standing", "task.yaml"),
        ("driving", DRIVING_TASK),
        ("driving, open loop", DRIVING_TASK),
    ):
        with open_loop() if "open" in name else ExitStack():
            row, run = runs(name, TASKS_FOLDER / file, given.runs, given.backend)
        print(row, flush=True)
        shown.append((name, *run))
    if given.plot:
        draw_tracking_errors([shown[0], shown[2], shown[1]], given.plot)


if __name__ == "__main__":
    main()
