"""PLACE of a book into a deep box in which other books are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from handcart.evaluation.activities.making import make
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.knowledge.object_names import name_in_world
from handcart.primitives.objects.knowledge.objects import Objects, ObjectSighting
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.geometry.pose2 import Pose2

from .fetching import scene_of

BOX, SPOT, LAST = "box_1_in_2", "for_book_6", "book_6"
BOXES = ("box_1_in_1", BOX)
START = {"x_m": 0.99, "y_m": 2.3, "heading_deg": 180}
HERE = {"x_m": 0.4526, "y_m": 2.2715, "heading_deg": 0}  # of the last book, on the side table
SEEN = ((4e-5, 0.0, 0.0), (0.0, 4e-5, 0.0), (0.0, 0.0, 1e-4))


def read(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8").replace(" on:", ' "on":'))


def holding_the_last_book(folder: Path, *things: dict[str, Any]) -> Rig:
    """Return a robot with the last book in its hand, before the box of boxing_books_up_for_storage."""
    pytest.importorskip("bddl")
    make("boxing_books_up_for_storage", 0, folder, "librarian", False)
    world, objects = read(folder / "world.yaml"), read(folder / "objects.yaml")
    spots = {(box, name): spot for box in BOXES for name, spot in objects["surfaces"][box]["spots"].items()}
    sightings = []
    for book in world["objects"]:
        name = book["name"]
        box, spot = next((box, spot) for (box, key), spot in spots.items() if key == f"for_{name}")
        on, at = ("side_table", HERE) if name == LAST else (box, spot)
        book |= {**at, "height_m": 0.55 if name == LAST else 0.01, "sigma_mm": 0.5, "sigma_deg": 0.2}
        objects["objects"][name] |= {"on": on, **at}
        if name != LAST:
            sightings.append(ObjectSighting(name, box, Pose2(spot["x_m"], spot["y_m"], 0.0), SEEN))
    world["objects"] += [{**thing, "height_m": 0.01, **spots[BOX, SPOT]} for thing in things]
    world["start"], places = START, read(folder / "places.yaml")
    places["places"]["home"] = START
    for name, data in (("world", world), ("objects", objects), ("places", places)):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    known = {"objects": folder / "objects.yaml"}
    files = RigFiles(folder / "world.yaml", folder / "map.yaml", folder / "places.yaml", known, "home")
    rig = build_rig(files, seed=6100)
    rig.model.of(Objects).sightings = tuple(sightings)
    taken = Pick(object=LAST, to=BOX, spot=SPOT)
    for primitive in (LookFor(object=LAST, surface="side_table"), taken, MoveTo(place=BOX)):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    return rig


@pytest.mark.slow
def test_last_spot_of_a_deep_box_is_seen_from_further_above(tmp_path: Path) -> None:
    """From the only near view that the arm reached, the box's side hid it: the book stayed outside."""
    with holding_the_last_book(tmp_path) as rig:
        outcome = rig.do(PlaceObject(surface=BOX, spot=SPOT))
        assert isinstance(outcome, Success), outcome
        book, spot = (
            scene_of(rig).thing_named(name_in_world(LAST)),
            rig.model.of(Objects).surface(BOX).spots[SPOT],
        )
        assert book is not None
        assert np.hypot(book.pose[0, 3] - spot.x_m, book.pose[1, 3] - spot.y_m) < 0.02


@pytest.mark.slow
def test_thing_at_the_bottom_of_a_deep_box_is_seen(tmp_path: Path) -> None:
    with holding_the_last_book(tmp_path, {"name": "card", "size_mm": [20, 60, 2], "grey": 150}) as rig:
        outcome = rig.do(PlaceObject(surface=BOX, spot=SPOT))
        assert isinstance(outcome, Fail), outcome
        assert outcome.cause.name == "occupied"
