"""`handcart compare`: two runs side by side."""

from __future__ import annotations

import io
import json
import shutil
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said
from tests.tools.past_runs.conftest import TWO_WAYS as TASK

Make = Callable[..., Path]
Handcart = Callable[..., Said]


def test_runs_with_the_same_ends_are_equal(handcart: Handcart, scripted_run: Make) -> None:
    said = handcart("compare", scripted_run(TASK, "one", near="F"), scripted_run(TASK, "other", near="F"))
    assert said.status == 0
    assert "the journals are equal but for the wall clock" in said.out


def test_the_first_different_outcome_is_named(handcart: Handcart, scripted_run: Make) -> None:
    one, other = scripted_run(TASK, "one", near="FF"), scripted_run(TASK, "other", near="F", ahead="G")
    said = handcart("compare", one, other)
    assert (
        "first difference, in outcome: THINK (a to b): A 2 Fail unnamed: near failed; B 2 Success" in said.out
    )
    assert "first different record: RESULT at" in said.out
    found = json.loads(handcart("compare", one, other, "--json").out)
    assert found["first_difference"] == 1
    assert [action["n"] for action in found["actions"]] == [[1, 1], [2, 2], [3, None], [None, 3]]
    assert found["actions"][3]["outcomes"] == [None, "GiveUp"]
    assert found["outcomes"] == ["Success", "GiveUp"]
    assert not found["equal"]


def test_actions_are_aligned_after_one_too_many(handcart: Handcart, scripted_run: Make) -> None:
    one, other = scripted_run(TASK, "one"), scripted_run(TASK, "other", near="F")
    rows = json.loads(handcart("compare", one, other, "--json").out)["actions"]
    assert [(row["to"], row["n"], row["differs"]) for row in rows][-1] == ("z", [2, 3], None)


def packed(folder: Path, path: Path) -> Path:
    """The run in an archive of the kind that the path's name says."""
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w") as archive:
            archive.write(folder / "journal.jsonl", "deep/in/journal.jsonl")
    else:
        with tarfile.open(path, "w:gz") as archive:
            archive.add(folder, "run")
    return path


@pytest.mark.parametrize("name", ["run.zip", "run.tar.gz"])
def test_a_run_is_read_from_an_archive(
    handcart: Handcart, scripted_run: Make, tmp_path: Path, name: str
) -> None:
    folder = scripted_run(TASK, "one", near="F")
    said = handcart("compare", folder, packed(folder, tmp_path / name))
    assert "the journals are equal" in said.out
    assert name in said.out


def test_what_holds_no_run_is_refused_in_words(
    handcart: Handcart, scripted_run: Make, tmp_path: Path
) -> None:
    folder = scripted_run(TASK, "one")
    text = tmp_path / "text.zip"
    text.write_text("no archive")
    empty = tmp_path / "empty.zip"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("a/journal.jsonl", "x")
        archive.writestr("b/journal.jsonl", "x")
    torn = tmp_path / "torn.tar.gz"
    torn.write_bytes(packed(folder, tmp_path / "good.tar.gz").read_bytes()[:200])
    for bad, wrong in (
        (text, "the archive is not readable"),
        (empty, "2 files journal.jsonl, not one"),
        (torn, "the archive is not readable"),
        (tmp_path / "nowhere", "there is no such folder"),
    ):
        said = handcart("compare", folder, bad)
        assert said.status == 2
        assert str(bad) in said.err
        assert wrong in said.err


def test_an_archive_cannot_write_outside_its_folder(
    handcart: Handcart, scripted_run: Make, tmp_path: Path
) -> None:
    folder = scripted_run(TASK, "one")
    path = tmp_path / "bad.tar"
    with tarfile.open(path, "w") as archive:
        archive.add(folder / "journal.jsonl", "run/journal.jsonl")
        for name in ("run/../../../escaped", "/tmp/escaped-as-well"):
            info = tarfile.TarInfo(name)
            info.size = 1
            archive.addfile(info, io.BytesIO(b"x"))
        link = tarfile.TarInfo("run/link")
        link.type, link.linkname = tarfile.SYMTYPE, str(folder)
        archive.addfile(link)
    shutil.rmtree(tmp_path / "task")
    assert handcart("compare", folder, path).status == 0
    assert not list(tmp_path.parent.rglob("escaped*"))
    assert not Path("/tmp/escaped-as-well").exists()
