"""Tests of the files that a section reads, and of its journaled part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

import pytest

from handcart.files.findings import Findings
from handcart.files.models.model import FileModel
from handcart.files.yaml.yaml_document import parse_document
from handcart.primitives.knowledge.section import NamedFiles, Section
from handcart.robotics.geometry.pose2 import Pose2


class Bed(FileModel):
    """A file."""

    format: Literal["handcart-bed/1"]
    rows: int


EMPTY = Bed(format="handcart-bed/1", rows=0)


@dataclass
class Garden(Section):
    """Two files, and something that is found out."""

    FILES: ClassVar = {"bed": Bed, "spare": Bed}
    LEARNED: ClassVar = ("weeds",)

    bed: Bed | None = None
    spare: Bed = EMPTY
    weeds: int = 0


@pytest.fixture
def files(tmp_path: Path) -> Callable[[str], NamedFiles]:
    """A task that names `bed` alone, with that text in it."""

    def made(text: str) -> NamedFiles:
        (tmp_path / "bed.yaml").write_text(text, encoding="utf-8")
        document = parse_document(b"knowledge: {bed: bed.yaml}\n", "task.yaml")
        return NamedFiles({"bed": tmp_path / "bed.yaml"}, Pose2(0.0, 0.0, 0.0), document, Findings())

    return made


def test_files_are_read_into_the_entries_of_their_names(files: Callable[[str], NamedFiles]) -> None:
    named = files("format: handcart-bed/1\nrows: 3\n")
    garden = Garden.load(named)
    assert garden.bed is not None
    assert garden.bed.rows == 3
    assert garden.spare is EMPTY  # none is named: the default applies
    assert not named.findings


def test_what_is_wrong_in_one_is_found_at_its_line(files: Callable[[str], NamedFiles]) -> None:
    named = files("format: handcart-bed/1\nrows: many\n")
    assert Garden.load(named).bed is None
    with pytest.raises(ValueError, match=r"bed\.yaml:2:7: "):
        named.findings.raise_all()


def test_what_was_learned_is_journaled() -> None:
    assert Garden(weeds=2).noted() == {"weeds": 2}
