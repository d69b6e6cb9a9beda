"""Paths in messages: relative inside the working directory, as given elsewhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import Finding
from handcart.files.shown_path import shown_path


def test_path_inside_the_working_directory_is_relative(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert str(Finding(str(tmp_path / "a" / "map.yaml"), 3, 1, "wrong")) == "a/map.yaml:3:1: wrong"
    assert str(Finding("--set a=1", 0, 0, "wrong")) == "--set a=1: wrong"
    for other in ("a/map.yaml", "../map.yaml", str(tmp_path), f"{tmp_path}-2/map.yaml", "/etc/map.yaml"):
        assert shown_path(other) == other


def test_path_is_shown_as_given_once_the_working_directory_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert shown_path(gone / "map.yaml") == str(gone / "map.yaml")
