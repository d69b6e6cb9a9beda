"""Ground truth of tracked seams: what contradicts a Success of TRACK."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.seam.seam_survey import SeamSurvey, distances
from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.outcomes.outcome import Success
from handcart.primitives.seam.track import Track
from handcart.robotics.geometry.transform import transform
from handcart.robotics.manipulation.paths.tool_path import tool_path

TASK = Path(__file__).parents[3] / "tasks" / "track_seam" / "task.yaml"

LEFT_OUT = "a point of its part of the seam is"


def test_distances_are_those_from_lines_and_from_a_single_point() -> None:
    path = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)])
    points = np.array([(0.5, 0.0, 0.2), (2.0, 0.5, 0.0), (-0.3, -0.4, 0.0)])
    assert distances(points, path) == pytest.approx([0.2, 1.0, 0.5])
    assert distances(points, path[:1]) == pytest.approx([np.hypot(0.5, 0.2), np.hypot(2.0, 0.5), 0.5])


@pytest.mark.parametrize(
    ("share", "aside", "wrong"),
    [
        (1.0, 0.004, []),
        (
            1.0,
            0.005,
            ["the tool was 5.0 mm off its part of the seam", f"{LEFT_OUT} 5.0 mm from where the tool was"],
        ),
        (0.9, 0.0, [f"{LEFT_OUT} 100.0 mm from where the tool was"]),
        (0.0, 0.0, ["the tool never was on its part of the seam"]),
    ],
)
def test_the_tool_was_on_the_whole_part_and_nowhere_else(
    share: float, aside: float, wrong: list[str]
) -> None:
    part = tool_path([transform((0.02 * step, 0.0, 0.5)) for step in range(51)])
    tips = iter([transform((0.01 * step, aside, 0.5)) for step in range(101)])
    world = SimpleNamespace(world_T=lambda _: next(tips))
    work = SimpleNamespace(next=SimpleNamespace(empty=False))
    model = SimpleNamespace(of=lambda _: SimpleNamespace(seam_work=work))
    robot: Any = SimpleNamespace(time=0.0, arm=SimpleNamespace(command=lambda: np.zeros(6)))
    survey, track = SeamSurvey(SimpleNamespace(model=model, world=world)), Track()  # type: ignore[arg-type]
    survey.started(1, track)
    track._part, track._at = part, 0
    for _ in range(round(share * 100) + (share > 0.0)):
        survey.look(robot)
    untrue = survey.ended(1, track, Success())
    assert [item.partition(" (")[0] for item in untrue] == wrong


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "wrong"),
    [(0.5, LEFT_OUT), (0.0, "the tool never was on its part of the seam")],
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
