"""Stacking blocks into walls and fences."""

from __future__ import annotations

from pathlib import Path

from .domain import Command, Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "blocks",
    knowledge=Knowledge(
        "handcart.primitives.blocks.blocks:Blocks",
        {"building": "A building plan: where blocks wait and where they go."},
    ),
    props="handcart.backends.simulation.blocks.block_props:BlockProps",
    physics="handcart.backends.physics.blocks.bodies:PROP_BODIES",
    primitives={
        "FIXATE": "handcart.primitives.blocks.fixate:Fixate",
        "PICK_UP_BLOCK": "handcart.primitives.blocks.pick_up_block:PickUpBlock",
        "STACK": "handcart.primitives.blocks.stack:Stack",
    },
    survey="handcart.evaluation.blocks.block_survey:BlockSurvey",
    files={
        "building": "handcart.primitives.blocks.building:Building",
        "drawing": "handcart.primitives.blocks.drawing:Drawing",
    },
    task_facts="handcart.evaluation.blocks.stop_check:block_facts",
    commands={
        "wall": Command("handcart.tools.blocks.wall:wall", "Plan how a drawn wall is built; write a task.")
    },
    rehearsals={
        _HERE / "stack_blocks" / "unload.yaml": {"blocks": "[1]"},
        _HERE / "stack_blocks" / "task.yaml": {"blocks": "[1]"},  # drives by its wheels alone
    },
)
