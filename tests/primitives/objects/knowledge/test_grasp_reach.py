"""Whether the arm can grip what is on a surface from the base's place, before anything moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.networks.task.preparing import check
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.knowledge.grasp_reach import grasp_work
from handcart.primitives.objects.knowledge.surface_places import NoStandingPlace, standing_place
from tests.primitives.objects.files.test_floor_surface import ROOM

from ..fetching import TASK, changed

HOME = Place(x_m=1.0, y_m=1.0, heading_deg=0.0)


def flat_object(height_m: float) -> ObjectsFile:
    """A plate 24 mm high on a table of some height."""
    table = {"x_m": 3.0, "y_m": 3.0, "height_m": height_m, "size_m": [0.7, 1.4]}
    plate = {"kind": "plate", "on": "table", "x_m": 2.8, "y_m": 3.0}
    kinds = {"plate": {"size_mm": [43, 77, 24]}}
    data = {"format": "handcart-objects/1", "kinds": kinds, "surfaces": {"table": table}}
    return ObjectsFile.model_validate({**data, "objects": {"plate_1": plate}})


@pytest.mark.parametrize(("height_m", "reached"), [(0.5, True), (0.73, False)])
def test_place_is_one_from_which_the_object_can_be_gripped(height_m: float, reached: bool) -> None:
    """Slanting ahead, the hand would reach 40 mm over the table, but not down to the plate."""
    robot, file = load_robot("xarm_cart"), flat_object(height_m)
    if reached:
        standing_place(robot, ROOM, file, "table", [HOME])
    else:
        with pytest.raises(NoStandingPlace, match="doesn't reach all work on the surface 'table'"):
            standing_place(robot, ROOM, file, "table", [HOME])


@pytest.mark.parametrize(
    ("shape", "sigma_deg", "count"), [("box", 0, 1), ("box", 30, 5), ("cylinder", 90, 1)]
)
def test_headings_are_those_that_are_believed(shape: str, sigma_deg: float, count: int) -> None:
    data = flat_object(0.5).model_dump(mode="json")
    data["kinds"]["plate"] |= {"shape": shape, "size_mm": [43, 43, 24]}
    data["objects"]["plate_1"]["sigma_deg"] = sigma_deg
    (work,) = grasp_work(ObjectsFile.model_validate(data), "table")
    assert len(work.headings) == count


def test_check_warns_of_headings_in_which_an_object_is_out_of_reach(tmp_path: Path) -> None:
    """A tall object is far above a small arm, which comes from its near side alone."""
    tall, high = ("[60, 90, 80]", "[55, 107, 141]"), ("y_m: 3.8, height_m: 0.6", "y_m: 3.8, height_m: 0.94")
    objects = changed(tmp_path, "objects.yaml", tall, high)
    settings = {"robot": "xarm_cart", "objects": str(objects)}
    warnings = [text for text in check(TASK / "task.yaml", settings=settings).warnings if "no grasp" in text]
    lines = objects.read_text(encoding="utf-8").splitlines()
    line = next(number for number, text in enumerate(lines, start=1) if text.startswith("  parcel_1:"))
    assert warnings
    assert f"objects.yaml:{line}:3: at the place before 'table_a'" in warnings[0]
    assert not [text for text in check(TASK / "task.yaml").warnings if "no grasp" in text]
