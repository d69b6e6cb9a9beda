"""Tracking a seam that is longer than the arm."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "seam",
    primitives={
        "DIVIDE": "handcart.primitives.divide:Divide",
        "TRACK": "handcart.primitives.track:Track",
    },
    survey="handcart.evaluation.seam_survey:SeamSurvey",
    files={"work-piece": "handcart.primitives.work_piece:WorkPiece"},
    rehearsals={_HERE / "track_seam" / "task.yaml": {"places_left": "[3]"}},
)
