"""What the command refuses without the package `bddl`: it names what to install, and keeps what is there."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from handcart.tools.main import main


def test_activity_without_the_package_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in [item for item in sys.modules if item.split(".")[0] == "bddl"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "bddl", None)
    with pytest.raises(SystemExit) as end:
        main(["activity", "store_honey", "-o", str(tmp_path / "honey")])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert "pip install 'handcart[bddl]'" in said
    assert "Traceback" not in said
    assert not (tmp_path / "honey").exists()


def test_activity_keeps_a_folder_with_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "task.yaml").write_text("mine")
    with pytest.raises(SystemExit) as end:
        main(["activity", "store_honey", "-o", str(tmp_path)])
    assert end.value.code == 2
    assert "there are files in it; allowed: a new or an empty folder" in capsys.readouterr().err
    assert (tmp_path / "task.yaml").read_text() == "mine"
