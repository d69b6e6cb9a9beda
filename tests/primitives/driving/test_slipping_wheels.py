"""A base that drives by its wheels alone, and slips: no outcome of MOVE_TO is false."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.faults.fault import FOR_GOOD, Fault, FaultKind
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.conformance.faults.underway import Ending, Underway
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo

TASK = Path(__file__).resolve().parents[3] / "tasks" / "stack_blocks"
FILES = RigFiles(
    TASK / "world.yaml",
    TASK / "map.yaml",
    TASK / "places.yaml",
    {"building": TASK / "building.yaml"},
    "supply",
)


def slipping(after: int, periods: int) -> Ending:
    """Drive by wheels of which half the roll is lost, from a period on."""
    with build_rig(FILES, "toyama", seed=1) as rig:
        backend = FaultyBackend(rig.backend)
        model, spec = rig.model, rig.robot.spec
        robot = Robot(backend, spec, model.places["supply"].pose, model.map)
        underway = Underway(MoveTo(place="stacking"), robot, backend, model, spec, 1)
        for _ in range(after):
            assert underway.advance() is None
        return underway.finish(Fault(FaultKind.SLIP, periods=periods, speed=0.1))


@pytest.mark.parametrize("after", [100, 150])
def test_a_short_slip_is_made_up_for(after: int) -> None:
    ending = slipping(after, 30)
    assert ending.bitten
    assert (ending.outcome, ending.wrong) == ("Success", ())


@pytest.mark.slow
def test_wheels_that_slip_for_good_claim_nothing_false() -> None:
    ending = slipping(60, FOR_GOOD)
    assert ending.bitten
    assert ending.outcome != "Success"
    assert ending.wrong == ()
