"""`--set KEY=VALUE`: read and checked like the file."""

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.files.models.loading import load
from handcart.files.models.model import FileModel
from handcart.files.models.settings import setting_value, split_setting, with_settings
from handcart.files.yaml.yaml_document import read_document


class Parameters(FileModel):
    map: str
    speed_m_s: float
    places: tuple[str, ...] = ()


class Task(FileModel):
    parameters: Parameters


@pytest.fixture
def task(tmp_path: Path) -> Path:
    path = tmp_path / "task.yaml"
    path.write_text("parameters:\n  map: a.yaml\n  speed_m_s: 0.4\n  places: [a]\n")
    return path


def test_values_are_set(task: Path) -> None:
    loaded = load(task, Task, {"map": "../x y.yaml", "speed_m_s": "1e-1", "places": "[b, 'c d']"})
    assert loaded.parameters == Parameters(map="../x y.yaml", speed_m_s=0.1, places=("b", "c d"))


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("speed_m_s", "fast", "--set speed_m_s=fast: speed_m_s is 'fast'; allowed: a number in m/s"),
        ("speed", "1", "--set speed=1: unknown parameter 'speed'; did you mean 'speed_m_s'?"),
        ("map", "NO", "--set map=NO: 'NO' is true or false to some readers"),
        (
            "speed_m_s",
            "0x10",
            "--set speed_m_s=0x10: '0x10' is a number to base 16; allowed: 16, or",
        ),
        ("speed_m_s", "0o10", "--set speed_m_s=0o10: '0o10' is a number to base 8; allowed: 8, or in quotes"),
        ("speed_m_s", "٣", "--set speed_m_s=٣: speed_m_s is '٣'; allowed: a number in m/s"),
        ("map", "1", "--set map=1: map is 1; allowed: text in quotes"),
        ("places", "[a, 3]", "--set places=[a, 3]: places[1] is 3; allowed: text in quotes"),
        ("places", "[a", "--set places=[a: a bracket is"),
        ("places", "[&a x]", "--set places=[&a x]: the anchor &a"),
        ("map", "\udcff", "--set map=\\udcff: the byte 0xff is not UTF-8"),
        ("map", "", "--set map=: map is empty; allowed: text"),
    ],
)
def test_bad_settings_are_refused_like_the_file(task: Path, key: str, value: str, said: str) -> None:
    with pytest.raises(FileError) as caught:
        load(task, Task, {key: value})
    assert str(caught.value).startswith(said)


def test_all_bad_settings_at_once(task: Path) -> None:
    with pytest.raises(FileError) as caught:
        load(task, Task, {"mapp": "x", "speed_m_s": "1:30"})
    assert len(caught.value.findings) == 2


def test_splitting() -> None:
    assert split_setting("map=a=b") == ("map", "a=b")
    for text in ("map", "=x", ""):
        with pytest.raises(FileError, match="allowed: KEY=VALUE"):
            split_setting(text)


def test_a_value_is_a_number_by_the_rules_of_files() -> None:
    assert setting_value("a", "1e-3").content == 0.001
    assert setting_value("a", "'1'").content == "1"


def test_what_was_set_can_be_told_from_what_stands_in_the_file(task: Path) -> None:
    document = with_settings(read_document(task), {"map": "b.yaml"})
    assert document.is_set(("parameters", "map"))
    assert not document.is_set(("parameters", "places", 0))
    assert document.data["parameters"]["map"] == "b.yaml"
    assert document.folder == task.parent
    assert document.sha256 == read_document(task).sha256
