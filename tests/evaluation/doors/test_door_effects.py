"""What a Success of OPEN and CLOSE promises, by the ground truth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.simulation.doors.spec import SimulatedDoorSpec
from handcart.evaluation.doors.door_effects import DOOR_EFFECTS
from handcart.primitives.doors.doors import Doors, DoorState
from handcart.primitives.doors.doors_file import DoorsFile
from handcart.primitives.doors.open_door import OpenDoor
from handcart.robotics.geometry.pose2 import Pose2

SPEC = SimulatedDoorSpec.model_validate(
    {
        "name": "drawer",
        "motion": "sliding",
        "handle": {"x_m": 4.0, "y_m": 1.0, "height_m": 0.85, "heading_deg": 180, "bar": "horizontal"},
        "height_mm": 200,
        "tags": [{"id": 21, "side_mm": 50, "up_mm": 60}],
    }
)


KNOWN = SPEC.model_dump(include={"motion", "handle", "tags"}, exclude_none=True) | {"place": "desk"}
DOORS = DoorsFile.model_validate({"format": "handcart-doors/1", "doors": {"drawer": KNOWN}})


def judged(
    primitive: str, truly: float, noted: float = 0.2, motion: str = "sliding", asked_mm: float = 200.0
) -> list[str]:
    """Return what is wrong with a Success that notes a drawer as open, in [m]."""
    state = DoorState("drawer", motion, noted, Pose2(4.0, 1.0, 0.0), 1.0)
    props = SimpleNamespace(parts={"handle drawer": SimpleNamespace(spec=SPEC)}, openings={"drawer": truly})
    run = SimpleNamespace(
        world=SimpleNamespace(of=lambda kind: props),
        model=SimpleNamespace(of=lambda kind: Doors(DOORS, door_states=(state,))),
    )
    survey: Any = SimpleNamespace(run=run)
    claim: Any = SimpleNamespace(primitive=OpenDoor(door="drawer", travel_mm=asked_mm))
    return DOOR_EFFECTS[primitive](survey, claim)


@pytest.mark.parametrize(("truly", "wrong"), [(0.2, 0), (0.205, 0), (0.215, 1), (0.0, 2)])
def test_drawer_must_be_where_open_left_it(truly: float, wrong: int) -> None:
    assert len(judged("OPEN", truly)) == wrong


@pytest.mark.parametrize(("asked_mm", "wrong"), [(200.0, 0), (208.0, 0), (250.0, 1)])
def test_drawer_must_be_as_open_as_asked(asked_mm: float, wrong: int) -> None:
    found = judged("OPEN", 0.2, asked_mm=asked_mm)
    assert len(found) == wrong
    assert not found or "its handle is 50.0 mm short of what was asked" in found[0]


def test_open_must_tell_hinged_from_sliding() -> None:
    assert judged("OPEN", 0.2, motion="hinged") == ["drawer is sliding, not hinged"]


@pytest.mark.parametrize(("truly", "wrong"), [(0.0, 0), (0.01, 0), (0.02, 1)])
def test_closed_drawer_must_be_at_its_stop(truly: float, wrong: int) -> None:
    assert len(judged("CLOSE", truly)) == wrong
