"""Opening and closing doors and drawers."""

from __future__ import annotations

from pathlib import Path

from .domain import Domain, Knowledge

_HERE = Path(__file__).parent

DOMAIN = Domain(
    "doors",
    knowledge=Knowledge(
        "handcart.primitives.doors.doors:Doors",
        {"doors": "Doors and drawers: their handles and tags, and how they are believed to move."},
    ),
    props="handcart.backends.simulation.doors.door_props:DoorProps",
    physics="handcart.backends.physics.doors.bodies:PROP_BODIES",
    primitives={
        "OPEN": "handcart.primitives.doors.open_door:OpenDoor",
        "CLOSE": "handcart.primitives.doors.close_door:CloseDoor",
    },
    survey="handcart.evaluation.doors.door_survey:DoorSurvey",
    faults="handcart.evaluation.doors.door_faults:DOOR_FAULTS",
    files={"doors": "handcart.primitives.doors.doors_file:DoorsFile"},
    rehearsals={_HERE / "open_drawer" / "task.yaml": {}},
)
