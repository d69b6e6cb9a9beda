"""LOOK_FOR, PICK and PLACE with a cylinder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Success

from ..fetching import changed, rig_with, scene_of

CAN_MM = "[66, 66, 115]"


def rig_with_can(folder: Path, backend: str, grasps: str, seed: int) -> Rig:
    """Return a rig with a can in place of the parcel, with a tag on its lid."""
    tag = ("{id: 7, side_mm: 40}", "{id: 7, side_mm: 32}")
    world = changed(
        folder,
        "world.yaml",
        ("size_mm: [60, 90, 80]\n    sigma", f"shape: cylinder\n    size_mm: {CAN_MM}\n    sigma"),
        tag,
    )
    kind = f"  can: {{shape: cylinder, size_mm: {CAN_MM}, mass_kg: 0.3, grasps: {grasps}}}\n  parcel: {{"
    objects = changed(
        folder,
        "objects.yaml",
        ("  parcel: {", kind),
        ("parcel_1: {kind: parcel", "parcel_1: {kind: can"),
        tag,
    )
    return rig_with(objects, world, seed=seed, backend=backend)


@pytest.mark.slow
def test_can_is_taken_and_weighed(tmp_path: Path) -> None:
    rig = rig_with_can(tmp_path, "kinematic", '["+z"]', seed=2)
    pick = Pick(object="parcel_1", stow=False)
    for primitive in (MoveTo(place="table_a"), LookFor(object="parcel_1"), pick):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    assert scene_of(rig).held.name == "object parcel_1"
    assert scene_of(rig).held.tilt() < 1e-3
    assert pick.evidence.facts["width_mm"] == pytest.approx(66.0, abs=0.5)


@pytest.mark.parametrize(
    ("backend", "grasps", "side"),
    [
        pytest.param("kinematic", "any", "+z", marks=pytest.mark.slow),
        pytest.param("kinematic", "[+x]", "side", marks=pytest.mark.slow),
        pytest.param("mujoco", "any", "+z", marks=pytest.mark.slow),
    ],
)
def test_can_is_carried_to_its_spot(backend: str, grasps: str, side: str, tmp_path: Path) -> None:
    rig = rig_with_can(tmp_path, backend, grasps, seed=2)
    pick, place = Pick(object="parcel_1"), PlaceObject(surface="table_b", spot="left")
    for primitive in (
        MoveTo(place="table_a"),
        LookFor(object="parcel_1"),
        pick,
        MoveTo(place="table_b"),
        place,
    ):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    can = scene_of(rig).thing_named("object parcel_1")
    assert np.hypot(*(can.pose[:2, 3] - (5.05, 2.2))) < 0.015
    assert can.pose[2, 3] == pytest.approx(0.6, abs=1e-3)
    assert pick.evidence.facts["from_side"] == side
    assert pick.evidence.facts["width_mm"] == pytest.approx(66.0, abs=0.5)
