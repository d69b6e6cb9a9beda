"""Tracking a seam that is longer than the arm."""

from __future__ import annotations

from pathlib import Path

from .domain import Command, Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "seam",
    knowledge=Knowledge(
        "handcart.primitives.seam.seam:Seam",
        {
            "seam": "A seam: a CSV file with a pose of the tool a line.",
            "work_piece": "What the seam is on.",
        },
    ),
    primitives={
        "DIVIDE": "handcart.primitives.seam.divide:Divide",
        "TRACK": "handcart.primitives.seam.track:Track",
    },
    survey="handcart.evaluation.seam.seam_survey:SeamSurvey",
    files={"work-piece": "handcart.primitives.seam.work_piece:WorkPiece"},
    task_facts="handcart.evaluation.seam.seam_check:seam_facts",
    commands={
        "place": Command(
            "handcart.tools.seam.place:place", "Divide a seam among places of the base; write a task."
        )
    },
    rehearsals={_HERE / "track_seam" / "task.yaml": {"places_left": "[3]"}},
)
