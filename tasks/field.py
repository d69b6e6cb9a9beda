"""Laying sensors across a field."""

from __future__ import annotations

from .domain import Domain

DOMAIN = Domain(
    "field",
    primitives={"DEPLOY": "handcart.primitives.deploy:Deploy"},
    survey="handcart.evaluation.field_survey:FieldSurvey",
)
