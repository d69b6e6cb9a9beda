"""Warnings of tags that a camera on a head sees too small from the base's place."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.networks.task.preparing import check
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.objects.knowledge.tag_sight import unread_words

from ..fetching import TASK, changed, rig_with
from ..head_robot import head_robot


def words_of(robot: str, file: ObjectsFile) -> dict[str, str]:
    return dict(unread_words(load_robot(robot), file, rig_with().model.of(Objects).stands))


@pytest.mark.parametrize(
    ("side_mm", "face", "warned"), [(40, "+z", False), (12, "+z", True), (12, "-z", False)]
)
def test_small_tag_is_warned_of_for_a_head_alone(
    tmp_path: Path, side_mm: int, face: str, warned: bool
) -> None:
    """A tag that never faces the camera has no width."""
    tag = f"tags: [{{id: 7, side_mm: {side_mm}, face: '{face}'}}]"
    objects = changed(tmp_path, "objects.yaml", ("tags: [{id: 7, side_mm: 40}]", tag))
    file = rig_with(objects).model.of(Objects).objects
    assert ("parcel_1" in words_of(str(head_robot(tmp_path / "head")), file)) is warned
    assert words_of("librarian", file) == {}


def test_check_tells_the_line_of_an_object_with_a_small_tag(tmp_path: Path) -> None:
    small = ("tags: [{id: 7, side_mm: 40}]", "tags: [{id: 7, side_mm: 12}]")
    objects = changed(tmp_path, "objects.yaml", small)
    settings = {"robot": str(head_robot(tmp_path / "head")), "objects": str(objects)}
    (found,) = (text for text in check(TASK / "task.yaml", settings=settings).warnings if "px wide" in text)
    lines = objects.read_text(encoding="utf-8").splitlines()
    line = next(number for number, text in enumerate(lines, start=1) if text.startswith("  parcel_1:"))
    assert f"objects.yaml:{line}:3: from the place before 'table_a' the camera sees" in found
