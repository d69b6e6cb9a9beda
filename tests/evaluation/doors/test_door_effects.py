"""What a Success of OPEN and CLOSE promises, by the ground truth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.simulation.doors.spec import SimulatedDoorSpec
from handcart.evaluation.doors.door_effects import DOOR_EFFECTS
from handcart.primitives.doors.doors import Doors, DoorState
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


def judged(primitive: str, truly: float, noted: float = 0.2, motion: str = "sliding") -> list[str]:
    """Return what is wrong with a Success that notes a drawer as open, in [m]."""
    state = DoorState("drawer", motion, noted, Pose2(4.0, 1.0, 0.0), 1.0)
    props = SimpleNamespace(parts={"handle drawer": SimpleNamespace(spec=SPEC)}, openings={"drawer": truly})
    run = SimpleNamespace(
        world=SimpleNamespace(of=lambda kind: props),
        model=SimpleNamespace(of=lambda kind: Doors(door_states=(state,))),
    )
    survey: Any = SimpleNamespace(run=run)
    claim: Any = SimpleNamespace(primitive=SimpleNamespace(door="drawer", facts={}))
    return DOOR_EFFECTS[primitive](survey, claim)


@pytest.mark.parametrize(("truly", "wrong"), [(0.2, 0), (0.205, 0), (0.215, 1), (0.0, 1)])
def test_drawer_must_be_where_open_left_it(truly: float, wrong: int) -> None:
    assert len(judged("OPEN", truly)) == wrong


def test_open_must_tell_hinged_from_sliding() -> None:
    assert judged("OPEN", 0.2, motion="hinged") == ["drawer is sliding, not hinged"]


@pytest.mark.parametrize(("truly", "wrong"), [(0.0, 0), (0.01, 0), (0.02, 1)])
def test_closed_drawer_must_be_at_its_stop(truly: float, wrong: int) -> None:
    assert len(judged("CLOSE", truly)) == wrong
