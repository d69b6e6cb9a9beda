"""A Success is held against what the hand truly holds: which thing, not that there is one."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.ground_truth import Body, GroundTruth
from handcart.evaluation.judging.hand_claims import false_hold
from handcart.evaluation.judging.survey import Claim, SurveyedRun, simulated_world
from handcart.evaluation.judging.surveys import Surveys
from handcart.evaluation.trials.rig import RigFiles, build_rig
from handcart.primitives.blocks.fixate import Fixate
from handcart.primitives.blocks.pick_up_block import PickUpBlock
from handcart.primitives.outcomes.outcome import Success
from handcart.primitives.preconditions.hand_use import (
    CARRIES_OBJECT,
    LETS_GO,
    TAKES_OBJECT,
    USE_UNDECLARED,
    USES_NO_FINGERS,
    HandUse,
)
from handcart.robotics.geometry.pose2 import Pose2

STACKING = Path(__file__).resolve().parents[3] / "tasks" / "stack_blocks"
BOTH = ("block 1", "block 2")


def truth(held: Collection[str]) -> GroundTruth:
    bodies = {name: Body("hand" if name in held else "tray", np.eye(4)) for name in BOTH}
    return GroundTruth(Pose2(0.0, 0.0, 0.0), np.zeros(2), np.zeros(2, dtype=bool), 0.05, bodies, 0)


def claim(use: HandUse, before: Collection[str], after: Collection[str], thing: str = "") -> Any:
    primitive = SimpleNamespace(
        hand_use=lambda: use,
        thing=lambda model: thing,
        meant_contacts=lambda model: (),
        label=lambda: "TRY",
        false_effect=lambda scene, before: (),
    )
    return Claim(primitive, truth(before), truth(after))


MODEL: Any = SimpleNamespace(view=lambda primitive: None)


@pytest.mark.parametrize(
    ("use", "before", "after", "thing", "wrong"),
    [
        (TAKES_OBJECT, (), ("block 2",), "block 2", []),
        (TAKES_OBJECT, (), ("block 1",), "block 2", ["the hand holds block 1, not block 2"]),
        (TAKES_OBJECT, (), (), "", ["the hand holds nothing, not something"]),
        (CARRIES_OBJECT, ("block 1",), ("block 1",), "block 1", []),
        (CARRIES_OBJECT, ("block 1",), (), "", ["the hand holds nothing, not block 1"]),
        (LETS_GO, ("block 1",), ("block 1",), "block 1", ["the hand holds block 1, not nothing"]),
        (USES_NO_FINGERS, ("block 1",), ("block 2",), "", ["the hand holds block 2, not block 1"]),
        (USE_UNDECLARED, ("block 1",), (), "", []),
    ],
)
def test_a_success_names_what_the_hand_holds(
    use: HandUse, before: Collection[str], after: Collection[str], thing: str, wrong: list[str]
) -> None:
    assert false_hold(claim(use, before, after, thing), MODEL) == wrong


def test_what_a_taking_primitive_drops_is_not_its_own() -> None:
    run: Any = SimpleNamespace(model=MODEL, world=None)
    surveys = Surveys.__new__(Surveys)
    surveys.run, surveys._every = run, []
    dropped = surveys._false_effect(claim(TAKES_OBJECT, ("block 1",), ("block 2",), "block 2"))
    assert dropped == ["it moved block 1 mm inf mm (at most 10)"]


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco"])
def test_a_dropped_block_makes_the_success_of_another_untrue(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A primitive whose precondition is not checked opens the fingers over the second block."""
    files = RigFiles(
        STACKING / "unload_world.yaml",
        STACKING / "map.yaml",
        STACKING / "places.yaml",
        {"building": STACKING / "building.yaml"},
        "stacking",
    )
    with build_rig(files, "toyama/h1", backend) as rig:
        for primitive in (Fixate(landmark="stacking"), PickUpBlock(number=1, at="robot")):
            assert isinstance(rig.do(primitive), Success)
        monkeypatch.setattr("handcart.primitives.contract.attempt.find_unmet", lambda *_: "")
        second = PickUpBlock(number=2, at="robot")
        world = simulated_world(rig.backend)
        does = frozenset({second.label()})
        surveys = Surveys(SurveyedRun(rig.robot, rig.robot.spec, rig.model, world, 0, does))
        surveys.started(1, second)
        outcome = rig.do(second)
        assert isinstance(outcome, Success), outcome
        wrong = surveys.ended(1, second, outcome)
        assert any("block 1" in item for item in wrong), wrong
