"""Household activities of BEHAVIOR-1K, judged by their own evaluator."""

from __future__ import annotations

from .domain import Command, Domain, Knowledge

DOMAIN = Domain(
    "activities",
    knowledge=Knowledge(
        "handcart.primitives.activities.activity:Activity",
        {"activity": "Definition of an activity of BEHAVIOR-1K, by which the end of a run is judged."},
    ),
    survey="handcart.evaluation.activities.activity_survey:ActivitySurvey",
    files={"activity": "handcart.primitives.activities.activity:ActivityFile"},
    commands={
        "activity": Command(
            "handcart.tools.activities.make_activity:make_activity",
            "Make world, objects and task from an activity of BEHAVIOR-1K.",
        )
    },
)
