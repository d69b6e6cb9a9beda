"""A base that drives by its wheels alone, and slips: no outcome of MOVE_TO is false."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.faults.fault import FOR_GOOD, Fault, FaultKind
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.evaluation.conformance.faults.underway import AttemptEnding, Underway
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.looks_at_rest import LooksAtRest
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success

TASK = Path(__file__).resolve().parents[3] / "tasks" / "stack_blocks"
FILES = RigFiles(
    TASK / "world.yaml",
    TASK / "map.yaml",
    TASK / "places.yaml",
    {"building": TASK / "building.yaml"},
    "supply",
)


def slipping(after: int, periods: int) -> AttemptEnding:
    """Drive by wheels of which half the roll is lost, from a period on."""
    with build_rig(FILES, "toyama", seed=1) as rig:
        backend = FaultyBackend(rig.backend)
        model, spec = rig.model, rig.robot.spec
        robot = Robot(backend, spec, model.places["supply"].pose, model.map)
        underway = Underway(MoveTo(place="stacking"), robot, backend, model, spec, 1)
        for _ in range(after):
            assert underway.advance() is None
        return underway.finish(Fault(FaultKind.SLIP, periods=periods, speed=0.1))


@pytest.mark.slow
@pytest.mark.parametrize("after", [100, 180])
def test_a_short_slip_is_made_up_for(after: int) -> None:
    """Not where it falls onto a slow part of the drive: there the wheels seem to turn against something."""
    ending = slipping(after, 30)
    assert ending.bitten
    assert (ending.outcome, ending.wrong) == ("Success", ())


@pytest.mark.slow
def test_a_slip_while_the_base_is_slow_claims_nothing_false() -> None:
    ending = slipping(150, 30)
    assert ending.bitten
    assert (ending.outcome in ("Success", "Fail"), ending.wrong) == (True, ())


@pytest.mark.slow
def test_wheels_that_slip_for_good_claim_nothing_false() -> None:
    ending = slipping(60, FOR_GOOD)
    assert ending.bitten
    assert ending.wrong == ()


def test_a_drive_by_wheels_stops_to_look_and_goes_on_then() -> None:
    """At a limit that is lower on the last stretch; from there until the scan has been looked at."""
    where = SimpleNamespace(added_sigma=0.0)
    looks = LooksAtRest(cast(Any, where))
    due = []
    for where.added_sigma, remaining in (
        (0.0, 3.0),
        (0.005, 2.0),
        (0.0065, 1.5),
        (0.003, 1.4),
        (0.0, 1.4),
        (0.001, 0.4),
        (0.003, 0.3),
        (0.0, 0.3),
    ):
        due.append(looks.due(remaining))
    assert due == [False, False, True, True, False, False, True, False]


@pytest.mark.slow
def test_a_drive_by_wheels_is_looked_at_on_the_way() -> None:
    """The drive ends if the sensors determine the pose as well as the place needs it."""
    with build_rig(FILES, "toyama", seed=2) as rig:
        added, stood = [], 0
        periods = attempt(MoveTo(place="stacking"), rig.robot, rig.model)
        while True:
            try:
                next(periods)
            except StopIteration as end:
                outcome = end.value
                break
            rig.robot.step()
            added.append(rig.robot.localization.added_sigma)
            stood += added[-1] == 0.0 and added[-2:-1] > [0.002]
        assert isinstance(outcome, Success)
        assert max(added) < 0.008
        assert stood >= 3
