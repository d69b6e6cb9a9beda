"""Contacts with passers: the robot drove into a person, or a person ran into the robot at rest."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.capabilities.base import Base, DriveCommand
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.evaluation.judging.contact_survey import ContactSurvey
from handcart.evaluation.judging.survey import SurveyedRun
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success

WORLD = """\
format: handcart-world/1
start: {x_m: 1, y_m: 1}
passers: [{name: bert, waypoints_m: [[3, 1], [1, 1]], speed_m_s: 0.5, at_end: stay}]
"""


@pytest.mark.parametrize(
    ("speed", "by_the_robot", "standing", "contradicted"), [(0.3, 1, 0, 1), (0.0, 0, 1, 0), (-0.1, 1, 0, 1)]
)
def test_contact_with_a_passer_counts_by_the_robots_speed(
    tmp_path: Path, speed: float, by_the_robot: int, standing: int, contradicted: int
) -> None:
    path = tmp_path / "world.yaml"
    path.write_text(WORLD, encoding="utf-8")
    spec, model, robot = load_robot("cart"), SimpleNamespace(), SimpleNamespace()
    with make_backend("kinematic", spec, path, 0) as backend:
        scene: Any = backend.scene  # type: ignore[attr-defined]
        survey = ContactSurvey(SurveyedRun(robot, spec, model, scene))  # type: ignore[arg-type]
        primitive = MoveTo(place="somewhere")
        survey.started(1, primitive)
        while not scene.contacts and scene.time < 20.0:
            backend.get(Base).drive(speed, 0.0)  # type: ignore[union-attr, type-abstract]
            backend.step()
            now: Any = SimpleNamespace(time=scene.time, period=backend.period, command=DriveCommand(speed))
            survey.look(now)
        figures = survey.figures()
        assert figures["contacts_by_the_robot"] == by_the_robot
        assert figures["was_run_into_while_standing"] == standing
        assert len(survey.ended(1, primitive, Success())) == contradicted
        assert figures["contacts_unmeant"] == by_the_robot
