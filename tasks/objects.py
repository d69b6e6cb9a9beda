"""Fetching and carrying objects that a file describes."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "objects",
    knowledge=Knowledge(
        "handcart.primitives.objects.knowledge.objects:Objects",
        {"objects": "Objects: their kinds, tags and surfaces, and where they are believed to be."},
    ),
    props="handcart.backends.simulation.objects.object_props:ObjectProps",
    physics="handcart.backends.physics.objects.bodies:PROP_BODIES",
    primitives={
        "LOOK_FOR": "handcart.primitives.objects.look_for:LookFor",
        "PICK": "handcart.primitives.objects.pick:Pick",
        "PLACE": "handcart.primitives.objects.place_object:PlaceObject",
        "STOW": "handcart.primitives.objects.stow:Stow",
        "MOVE_ARM": "handcart.primitives.objects.move_arm:MoveArm",
        "HAND_OVER": "handcart.primitives.objects.hand_over:HandOver",
    },
    survey="handcart.evaluation.objects.object_survey:ObjectSurvey",
    files={"objects": "handcart.primitives.objects.files.objects_file:ObjectsFile"},
    faults="handcart.evaluation.objects.object_faults:OBJECT_FAULTS",
    mutants="handcart.evaluation.objects.object_mutants:OBJECT_MUTANTS",
    rehearsals={
        _HERE / "fetch_and_carry" / "task.yaml": {},
        _HERE / "fetch_and_carry" / "set_aside.yaml": {},
        _HERE / "fetch_and_carry" / "hand_over.yaml": {},
    },
)
