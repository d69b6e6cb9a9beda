"""Laying sensors across a field."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent / "deploy_straight"

DOMAIN = Domain(
    "field",
    primitives={"DEPLOY": "handcart.primitives.deploy:Deploy"},
    rehearsals={_HERE / "task.yaml": {"targets": str(_HERE / "one_target.csv")}},
    survey="handcart.evaluation.field_survey:FieldSurvey",
)
