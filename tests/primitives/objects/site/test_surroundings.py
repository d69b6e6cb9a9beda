"""What the arm keeps clear of at a surface: seen objects, and unseen ones about where they are believed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.objects.knowledge.objects import HeldObject, Objects, ObjectSighting
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.looking.object_look import ObjectLook, look_closely
from handcart.primitives.objects.site.object_site import base_T_map, surroundings
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.evidence import Evidence
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import inverse, transform
from handcart.robotics.kinematics.shapes import Box, Cylinder, Solid

from ..fetching import changed, rig_with

SURE = ((4e-6, 0.0, 0.0), (0.0, 4e-6, 0.0), (0.0, 0.0, 1e-5))
PARCEL_RADIUS_M = 0.0541  # half the diagonal of 60 x 90 mm


def kept_clear(rig: Rig, without: str = "") -> dict[str, Solid]:
    """Return what is kept clear of, on the map, by its name."""
    to_map = inverse(base_T_map(rig.robot))
    view = rig.model.view(LookFor(object="parcel_1"))  # type: ignore[arg-type]
    return {
        surrounding.name: surrounding.seen_from(to_map)
        for surrounding in surroundings(rig.robot, view, without)
    }


def note_seen(rig: Rig, name: str, x: float, y: float) -> None:
    objects = rig.model.of(Objects)
    objects.sightings = (
        *objects.without(name),
        ObjectSighting(name, "table_a", Pose2(x, y, 0.0), SURE),
    )


@pytest.mark.parametrize(("sigma_mm", "beyond_m"), [("20", 0.04), ("40", 0.08), ("500", 0.12)])
def test_unseen_object_is_kept_clear_of_by_two_sigmas(tmp_path: Path, sigma_mm: str, beyond_m: float) -> None:
    line = "parcel_2: {kind: parcel, on: table_a, x_m: 2.3, y_m: 3.7,"
    rig = rig_with(changed(tmp_path, "objects.yaml", (line, f"{line} sigma_mm: {sigma_mm},")))
    found = kept_clear(rig)["object parcel_2"]
    assert isinstance(found, Cylinder)
    assert found.radius == pytest.approx(PARCEL_RADIUS_M + beyond_m, abs=1e-4)
    assert found.pose[:2, 3] == pytest.approx((2.3, 3.7))
    assert found.pose[2, 3] == pytest.approx(0.6 + 0.04)


def test_seen_object_is_kept_clear_of_where_it_was_seen() -> None:
    rig = rig_with()
    note_seen(rig, "parcel_2", 2.25, 3.75)
    found = kept_clear(rig)["object parcel_2"]
    assert isinstance(found, Box)
    assert np.asarray(found.pose)[:2, 3] == pytest.approx((2.25, 3.75))


def test_held_object_is_at_its_believed_place_no_more() -> None:
    rig = rig_with()
    assert {"object parcel_1", "object parcel_2"} <= kept_clear(rig).keys()
    assert "object parcel_1" not in kept_clear(rig, without="parcel_1")
    rig.model.of(Objects).held_object = HeldObject("parcel_1", transform((0.1, 0.0, 0.0)))
    assert "object parcel_1" not in kept_clear(rig)


def test_object_that_a_person_has_is_kept_clear_of_where_it_is_seen() -> None:
    rig = rig_with()
    rig.model.of(Objects).handed_over = ("parcel_1",)
    assert "object parcel_1" not in kept_clear(rig)
    note_seen(rig, "parcel_1", 1.9, 3.7)  # put back by the person
    assert "object parcel_1" in kept_clear(rig)


@pytest.mark.parametrize(("x", "radius"), [(1.9, 0.1341), (2.13, 0.09), (2.23, None)])
def test_belief_does_not_reach_to_what_was_seen_closely(x: float, radius: float | None) -> None:
    """A neighbour within 50 mm would have been seen with it; one beyond is still somewhere."""
    rig = rig_with()
    note_seen(rig, "parcel_1", x, 3.7)
    kept = kept_clear(rig, without="parcel_1").get("object parcel_2")
    assert (None if kept is None else kept.radius) == pytest.approx(radius, abs=1e-4)  # type: ignore[union-attr]


def test_unseen_objects_are_left_out_where_asked() -> None:
    rig = rig_with()
    view = rig.model.view(LookFor(object="parcel_1"))  # type: ignore[arg-type]
    names = {body.name for body in surroundings(rig.robot, view, believed=False)}
    assert "table_a" in names
    assert "object parcel_2" not in names


def test_object_looked_at_is_only_where_it_is_expected(monkeypatch: pytest.MonkeyPatch) -> None:
    """A released object is neither held nor seen; it isn't at its believed place either."""

    def at_once(_: object, function: Any, *arguments: Any) -> Any:
        return function(*arguments)
        yield

    rig, around = rig_with(), []
    monkeypatch.setattr(type(rig.robot), "compute", at_once)
    looking = "handcart.primitives.objects.looking.object_look"
    monkeypatch.setattr(f"{looking}.collision_model", lambda robot, held, bodies: around.append(bodies))
    monkeypatch.setattr(f"{looking}.view_joints", lambda *_: None)
    view, goal = rig.model.view(LookFor(object="parcel_1")), transform((0.9, 0.0, 0.6))  # type: ignore[arg-type]
    with pytest.raises(Discrepancy, match="no view of parcel_1 is free"):
        list(look_closely(rig.robot, view, "parcel_1", goal, ObjectLook(), Evidence()))
    own = [[body for body in bodies if body.name == "object parcel_1"] for bodies in around]
    assert own
    assert all(isinstance(body, Box) for bodies in own for body in bodies)
