"""Tests from files to models: every error at its place, in the words of files (rows T7, T10, T11, T13)."""

import os
from enum import Enum
from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import AfterValidator, Field, TypeAdapter, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from handcart.files.errors import FileError
from handcart.files.findings import Findings
from handcart.files.inside import FilePath
from handcart.files.models.loading import collect, load, load_document, load_part
from handcart.files.models.model import FileModel
from handcart.files.regular_file import read_regular_file
from handcart.files.yaml.yaml_document import parse_document


class Side(Enum):
    LEFT = "left"
    RIGHT = "right"


class FromModel(FileModel):
    model: str


class Move(FileModel):
    kind: Literal["move"]
    speed_m_s: Annotated[float, Field(gt=0, le=2)]


class Turn(FileModel):
    kind: Literal["turn"]
    angle_deg: Annotated[float, Field(ge=-180, le=180)]


class Book(FileModel):
    number: int
    width_mm: Annotated[float, Field(ge=15, le=45)]


class Shelf(FileModel):
    name: str
    side: Side = Side.LEFT
    place: str | FromModel = "here"
    corner_m: tuple[float, float] = (0.0, 0.0)
    step: Annotated[Move | Turn, Field(discriminator="kind")] | None = None
    books: tuple[Book, ...] = ()
    weights_kg: dict[str, float] = Field(default_factory=dict)
    rows: dict[int, str] = Field(default_factory=dict)
    lengths_mm: Annotated[list[float], Field(min_length=2)] | float = 1.0
    mesh: FilePath = "shelf.stl"
    open: bool = False

    @field_validator("name")
    @classmethod
    def _known(cls, name: str, info: ValidationInfo) -> str:
        if info.context and name not in info.context:
            raise ValueError("no such shelf; allowed: those of the map")
        return name

    @model_validator(mode="after")
    def _room(self) -> "Shelf":
        if len(self.books) > 2:
            raise ValueError("too many books; allowed: 2")
        return self


def messages(text: str, context: object = None) -> list[str]:
    with pytest.raises(FileError) as caught:
        load_document(parse_document(text.encode(), "f.yaml"), Shelf, context)
    return [str(finding).removeprefix("f.yaml:") for finding in caught.value.findings]


def test_loads_what_is_right(tmp_path: Path) -> None:
    path = tmp_path / "shelf.yaml"
    path.write_text(
        "name: a\nside: right\nplace: {model: book.shelf}\ncorner_m: [1, 2.5]\nrows: {1: low}\n"
        "step: {kind: turn, angle_deg: 90}\nbooks:\n  - {number: 1, width_mm: 2e1}\n"
    )
    shelf = load(path, Shelf)
    assert shelf.side is Side.RIGHT
    assert shelf.place == FromModel(model="book.shelf")
    assert shelf.corner_m == (1.0, 2.5)
    assert shelf.step == Turn(kind="turn", angle_deg=90)
    assert shelf.books == (Book(number=1, width_mm=20.0),)
    assert shelf.rows == {1: "low"}


@pytest.mark.parametrize("text", ["'20'", "true", "[20]", "~", "2O"])
def test_t07_only_a_number_is_a_number(text: str) -> None:
    (finding,) = messages(f"name: a\nbooks:\n  - number: 1\n    width_mm: {text}\n")
    assert finding.startswith("4:15: width_mm is ")
    assert finding.endswith("; allowed: a number from 15 to 45 mm")


@pytest.mark.parametrize("text", ["1.0", "true", "'1'"])
def test_t07_only_a_whole_number_is_one(text: str) -> None:
    (finding,) = messages(f"name: a\nbooks: [{{number: {text}, width_mm: 20}}]")
    assert finding == f"2:18: number is {text}; allowed: a whole number"


def test_a_number_for_text_needs_quotes() -> None:
    assert messages("name: 512.7") == ["1:7: name is 512.7; allowed: text in quotes"]


def test_list_with_a_wrong_item_is_not_called_too_short_as_well() -> None:
    (finding,) = messages("name: a\nlengths_mm: [1, x]")
    assert finding.startswith("2:17: lengths_mm[1] is 'x'")
    (short,) = messages("name: a\nlengths_mm: [x]")
    assert "lengths_mm" in short


def test_t10_unknown_key_at_its_place_with_the_nearest() -> None:
    assert messages("name: a\nbooks:\n  - number: 1\n    width_m: 20\n") == [
        "4:5: unknown key 'width_m'; did you mean 'width_mm'? allowed: number, width_mm",
    ]
    assert messages("name: a\nstep:\n  kind: move\n  speed_m_s: 1\n  sped: 3") == [
        "5:3: unknown key 'sped'; did you mean 'speed_m_s'? allowed: kind, speed_m_s"
    ]


def test_t11_range_with_the_unit_of_the_key() -> None:
    assert messages("name: a\nstep: {kind: move, speed_m_s: 3000}\nweights_kg: {a: x}") == [
        "2:31: speed_m_s is 3000; allowed: a number above 0 and at most 2 m/s",
        "3:17: a is 'x'; allowed: a number",
    ]


def test_words_of_an_enumeration() -> None:
    assert messages("name: a\nside: rigth") == [
        "2:7: side is 'rigth'; did you mean 'right'? allowed: left, right"
    ]


def test_kinds_without_jargon() -> None:
    assert messages("name: a\nstep: {kind: mov}") == [
        "2:14: kind is 'mov'; did you mean 'move'? allowed: move, turn"
    ]
    assert messages("name: a\nstep: {angle_deg: 1}") == [
        "2:7: the key 'kind' is missing; allowed: move, turn"
    ]
    assert messages("name: a\nstep: 3") == ["2:7: step is 3; allowed: a mapping with kind: move, turn"]


def test_one_finding_for_a_choice_of_types() -> None:
    assert messages("name: a\nplace: {modl: x}") == [
        "2:9: unknown key 'modl'; did you mean 'model'? allowed: model",
    ]
    assert messages("name: a\nplace: 3") == [
        "2:8: place is 3; allowed: text in quotes or a mapping with the key model"
    ]
    assert messages("name: a\nlengths_mm: [1]") == [
        "2:13: lengths_mm is a list of 1; allowed: a list of at least 2 entries"
    ]
    assert messages("name: a\nlengths_mm: [1, x]") == ["2:17: lengths_mm[1] is 'x'; allowed: a number in mm"]


def test_lists_keys_and_the_whole_file() -> None:
    assert messages("name: a\ncorner_m: [1]") == ["2:11: corner_m is too short; allowed: a list of 2"]
    assert messages("name: a\nrows:\n  x: low") == ["3:3: the key 'x' does not fit; allowed: a whole number"]
    (finding,) = messages("- 1")
    assert finding.startswith("1:1: the file is a list of 1; allowed: a mapping with the keys name, side, ")


def test_validators_of_the_model_speak_for_themselves() -> None:
    assert messages("name: b", context={"a"}) == ["1:7: name: no such shelf; allowed: those of the map"]
    book = "{number: 1, width_mm: 20}"
    assert messages(f"name: b\nbooks: [{book}, {book}, {book}]") == [
        "1:1: the file: too many books; allowed: 2"
    ]


def test_t13_paths_in_models() -> None:
    assert messages("name: a\nmesh: /etc/passwd") == [
        "2:7: mesh: the path '/etc/passwd' is absolute; allowed: a relative path inside the root"
    ]


def test_everything_is_told_at_once() -> None:
    assert len(messages("side: up\nplace: 3\ncorner_m: x\nopen: 1\nmesh: 'C:/x'\nzz: 1")) == 7


def test_a_part_of_a_type_known_later() -> None:
    document = parse_document(
        b"do:\n  - with: {kind: move, speed_m_s: 9}\n  - with: {angle_deg: 1}\n", "f.yaml"
    )
    findings = Findings()
    assert collect(findings, document, ("do", 0, "with"), Move) is None
    assert collect(findings, document, ("do", 1, "with"), TypeAdapter(dict[str, int])) == {"angle_deg": 1}
    findings.add(document.finding(("do", 1), "a later check; allowed: nothing", at_key=True))
    with pytest.raises(FileError) as caught:
        findings.raise_all()
    assert str(caught.value).splitlines() == [
        "f.yaml:2:35: speed_m_s is 9; allowed: a number above 0 and at most 2 m/s",
        "f.yaml:3:5: a later check; allowed: nothing",
    ]
    with pytest.raises(FileError, match=r"^f\.yaml:1:1: the key 'goal' is missing"):
        load_part(document, ("goal",), Move)


def test_loaded_refuses_at_a_place() -> None:
    loaded = load_document(parse_document(b"name: a\nside: left", "f.yaml"), Shelf)
    assert str(loaded.refuse(("side",), "blocked; allowed: right")) == "f.yaml:2:7: blocked; allowed: right"


class Tree(FileModel):
    name: str
    height_m: float = 1.0
    children: "tuple[Tree, ...]" = ()


def test_models_that_hold_themselves() -> None:
    text = "name: a\nchildren:\n  - name: b\n    children: [{name: c, hight_m: 1}]\n"
    with pytest.raises(
        FileError, match=r"^f:4:26: unknown key 'hight_m'; did you mean 'height_m'\? allowed: name"
    ):
        load_document(parse_document(text.encode(), "f"), Tree)


Even = Annotated[int, Field(multiple_of=2)]


@pytest.mark.parametrize("text", ["a: 3", "a: {b: 1}", "a: [1, x]", "a: 1.5", "a: zz"])
def test_no_jargon_whatever_the_type(text: str) -> None:
    adapter: TypeAdapter[object] = TypeAdapter(
        dict[str, Even | Literal["x", "y"] | Side | frozenset[Literal[1, "a"]] | tuple[Even, ...] | Move]
    )
    with pytest.raises(FileError) as caught:
        load_document(parse_document(text.encode(), "f.yaml"), adapter)
    for jargon in ("function-", "union", "literal[", "Input", "tuple[", "pydantic", "Annotated"):
        assert jargon not in str(caught.value)


def _own(value: int) -> int:
    if value == 7:
        raise PydanticCustomError("seven", "seven is taken; allowed: others")
    return value


def test_bounds_around_validators_and_errors_of_ones_own() -> None:
    number = Annotated[int, AfterValidator(_own), Field(ge=3)]
    adapter: TypeAdapter[object] = TypeAdapter(dict[str, number])
    with pytest.raises(FileError) as caught:
        load_document(parse_document(b"a: 1\nb: 7\n", "f"), adapter)
    assert str(caught.value).splitlines() == [
        "f:1:4: a is 1; allowed: greater than or equal to 3",
        "f:2:4: b: seven is taken; allowed: others",
    ]
    with pytest.raises(FileError, match="a is 3; allowed: a multiple of 2"):
        load_document(parse_document(b"a: 3", "f"), TypeAdapter(dict[str, Even]))


def test_a_file_that_grows_while_it_is_read_is_not_read_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was small when it was asked how large it is."""
    path, asked = tmp_path / "log.yaml", os.fstat
    path.write_bytes(b"x" * 2000)
    small = tmp_path / "small"
    small.write_bytes(b"x")
    monkeypatch.setattr(os, "fstat", lambda file: os.stat(small))
    with pytest.raises(FileError, match="allowed: at most 1000"):
        read_regular_file(path, 1000)
    monkeypatch.setattr(os, "fstat", asked)
    assert len(read_regular_file(path, 2000)) == 2000
