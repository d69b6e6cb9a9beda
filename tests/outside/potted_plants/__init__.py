"""Watering potted plants: a domain of its own, beside those that handcart ships."""

from __future__ import annotations

from pathlib import Path

from handcart.tasks.domain import Domain, Knowledge

PLANTS = Domain(
    "plants",
    knowledge=Knowledge(
        "potted_plants.knowledge:Plants",
        {"garden": "Plants: where their pots stand, how much water each needs, where the can is."},
    ),
    props="potted_plants.props:Pots",
    primitives={"WATER": "potted_plants.water:Water"},
    survey="potted_plants.survey:Watering",
    faults="potted_plants.survey:FAULTS",
    files={"plants": "potted_plants.knowledge:PlantsFile"},
    rehearsals={Path(__file__).parent / "garden" / "task.yaml": {"plants": "[basil]"}},
)
