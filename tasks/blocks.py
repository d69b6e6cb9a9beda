"""Stacking blocks into walls and fences."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "blocks",
    primitives={
        "FIXATE": "handcart.primitives.fixate:Fixate",
        "PICK_UP_BLOCK": "handcart.primitives.pick_up_block:PickUpBlock",
        "STACK": "handcart.primitives.stack:Stack",
    },
    survey="handcart.evaluation.block_survey:BlockSurvey",
    files={"building": "handcart.primitives.building:Building"},
    rehearsals={_HERE / "stack_blocks" / "unload.yaml": {"blocks": "[1]"}},
)
