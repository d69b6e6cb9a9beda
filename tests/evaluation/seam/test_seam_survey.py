"""Ground truth of tracked seams: what contradicts a Success of TRACK."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.seam.seam_survey import distances
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.seam.track import Track

TASK = Path(__file__).parents[3] / "tasks" / "track_seam" / "task.yaml"


def test_distances_are_those_from_lines_and_from_a_single_point() -> None:
    path = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)])
    points = np.array([(0.5, 0.0, 0.2), (2.0, 0.5, 0.0), (-0.3, -0.4, 0.0)])
    assert distances(points, path) == pytest.approx([0.2, 1.0, 0.5])
    assert distances(points, path[:1]) == pytest.approx([np.hypot(0.5, 0.2), np.hypot(2.0, 0.5), 0.5])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "wrong"),
    [(0.5, "a point of its part of the seam is"), (0.0, "the tool never was on its part of the seam")],
)
def test_a_success_of_a_part_that_was_not_tracked_is_false(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float, wrong: str
) -> None:
    honest = Track._on_seam

    def cut_off(self: Track, robot: Robot, part: object, plan: object) -> Periods:
        timed, tools = plan.timed, plan.tools  # type: ignore[attr-defined]
        few = round(share * len(tools.points))
        less = plan._replace(  # type: ignore[attr-defined]
            timed=timed._replace(set_points=timed.set_points[:few]),
            tools=tools._replace(points=tools.points[:few]),
        )
        yield from honest(self, robot, part, less)  # type: ignore[arg-type]

    monkeypatch.setattr(Track, "_on_seam", cut_off)
    summary, _ = run_task(TASK, tmp_path, RunOptions(seed=0, backend="kinematic"))
    assert any(wrong in item for item in summary["metrics"]["untrue"])
