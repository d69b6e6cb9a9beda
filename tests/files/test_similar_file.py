"""The file that is meant where a path leads nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.files.regular_file import read_regular_file
from handcart.files.suggest import did_you_mean


@pytest.mark.parametrize(
    ("asked", "question"),
    [
        ("meshes/visual/a.STL", "did you mean 'a.stl'? "),
        ("Meshes/Visual/a.STL", "did you mean 'meshes/visual/a.stl'? "),
        ("meshes/Visual/a.stl", "did you mean 'visual/a.stl'? "),
        ("meshes/visual/aa.stl", "did you mean 'a.stl'? "),
        ("meshes/visual/wheel.dae", ""),
        ("meshes/visal/a.stl", ""),
        ("meshes/visual/sub/a.stl", ""),
        ("meshes/visual/" + 300 * "a", ""),
    ],
)
def test_missing_file_is_compared_with_those_there(tmp_path: Path, asked: str, question: str) -> None:
    (tmp_path / "meshes" / "visual" / "sub").mkdir(parents=True)
    (tmp_path / "meshes" / "visual" / "a.stl").touch()
    assert did_you_mean(tmp_path / asked) == question


def test_message_about_a_missing_file_names_the_one_meant(tmp_path: Path) -> None:
    (tmp_path / "Drive.EDS").touch()
    with pytest.raises(FileError) as error:
        read_regular_file(tmp_path / "drive.eds", 10)
    assert "the file does not exist; did you mean 'Drive.EDS'? allowed: a regular file" in str(error.value)
