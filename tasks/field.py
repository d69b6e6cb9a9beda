"""Laying sensors across a field."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain, Knowledge

_HERE = Path(__file__).parent / "deploy_straight"

DOMAIN = Domain(
    "field",
    knowledge=Knowledge(
        "handcart.primitives.field.field_work:FieldWork",
        {
            "field": "A field: how far it reaches, and what is known to stand there.",
            "targets": "Where sensors go in it: CSV or GeoJSON.",
        },
    ),
    files={"field": "handcart.primitives.field.field:Field"},
    primitives={"DEPLOY": "handcart.primitives.field.deploy:Deploy"},
    props="handcart.backends.simulation.field.field_props:FieldProps",
    physics="handcart.backends.physics.field.bodies:PROP_BODIES",
    rehearsals={_HERE / "task.yaml": {"targets": str(_HERE / "one_target.csv")}},
    survey="handcart.evaluation.field.field_survey:FieldSurvey",
)
