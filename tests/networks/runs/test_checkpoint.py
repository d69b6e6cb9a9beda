"""A checkpoint is whole, and on the disk where it has to be, before it takes the place of the last one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from handcart.backends.saved_state import NotAState, digest, pack, unpack
from handcart.networks.runs.checkpoint import CHECKPOINT_FILE, NotKeptError, keep_checkpoint, load_checkpoint

SUCCESS = {"n": 4, "outcome": "Success"}
WHOLE: Mapping[str, Any] = {
    "format": "handcart-checkpoint/8",
    "after": "abc",
    "result": SUCCESS,
    "time_s": 2.5,
    "backend": {"wheels": 1.0},
    "robot": {"x": 2.0},
    "model": {"places": {}},
}


class Part:
    """A backend, robot or model whose state is known, and which notes the one that it is given."""

    def __init__(self, state: object, simulated: bool = True) -> None:
        self.given: list[object] = []
        self.simulated, self.time = simulated, 2.5
        self._state = state

    def state(self) -> object:
        return self._state

    def set_state(self, state: object) -> None:
        self.given.append(state)


def prepared(simulated: bool = True, backend: object = WHOLE["backend"]) -> Any:
    return SimpleNamespace(
        backend=Part(backend, simulated), robot=Part(WHOLE["robot"]), model=Part(WHOLE["model"])
    )


def test_checkpoint_comes_back_as_it_was_kept(tmp_path: Path) -> None:
    name = keep_checkpoint(tmp_path, prepared(), False, SUCCESS, "abc")
    content = (tmp_path / CHECKPOINT_FILE).read_bytes()
    assert unpack(content) == WHOLE
    kept = load_checkpoint(tmp_path)
    assert kept is not None
    assert name == kept.digest == digest(content)
    assert (kept.after, kept.result, kept.time_s) == ("abc", SUCCESS, 2.5)
    assert (kept.backend, kept.robot, kept.model) == (WHOLE["backend"], WHOLE["robot"], WHOLE["model"])
    assert [path.name for path in tmp_path.iterdir()] == [CHECKPOINT_FILE]
    assert (tmp_path / CHECKPOINT_FILE).stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("durable", [True, False])
def test_checkpoint_is_on_the_disk_before_it_replaces_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, durable: bool
) -> None:
    keep_checkpoint(tmp_path, prepared(), False, SUCCESS, "before")
    done: list[tuple[str, object]] = []
    replace = os.replace

    def sync(file: int) -> None:
        new = tmp_path / f"{CHECKPOINT_FILE}.new"
        assert os.path.samestat(os.fstat(file), new.stat())
        done.append(("sync", unpack(new.read_bytes())["after"]))

    def replaced(new: Path, old: Path) -> None:
        done.append(("replace", unpack(old.read_bytes())["after"]))
        replace(new, old)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(os, "replace", replaced)
    keep_checkpoint(tmp_path, prepared(), durable, SUCCESS, "after")
    assert done == [("sync", "after")] * durable + [("replace", "before")]
    kept = load_checkpoint(tmp_path)
    assert kept is not None
    assert kept.after == "after"


@pytest.mark.parametrize("left", ["a file", "a link"])
def test_what_a_crash_left_half_written_is_no_obstacle(tmp_path: Path, left: str) -> None:
    new, elsewhere = tmp_path / f"{CHECKPOINT_FILE}.new", tmp_path / "elsewhere"
    elsewhere.write_text("mine")
    new.symlink_to(elsewhere) if left == "a link" else new.write_bytes(b"half")
    assert keep_checkpoint(tmp_path, prepared(), False, SUCCESS, "x")
    assert (elsewhere.read_text(), new.exists()) == ("mine", False)
    assert load_checkpoint(tmp_path) is not None


def test_a_disk_that_takes_no_checkpoint_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    with pytest.raises(NotKeptError, match=r"gone/checkpoint can't be written: No such file"):
        keep_checkpoint(folder, prepared(), False, SUCCESS, "x")


def test_a_simulated_world_that_can_not_be_kept_keeps_nothing(tmp_path: Path) -> None:
    assert keep_checkpoint(tmp_path, prepared(backend=None), False, SUCCESS, "x") is None
    assert list(tmp_path.iterdir()) == []
    assert load_checkpoint(tmp_path) is None
    assert keep_checkpoint(tmp_path, prepared(simulated=False, backend=None), False, SUCCESS, "x")


def test_a_run_is_put_back_where_it_stood(tmp_path: Path) -> None:
    keep_checkpoint(tmp_path, prepared(), False, SUCCESS, "x")
    kept, again = load_checkpoint(tmp_path), prepared()
    assert kept is not None
    kept.put_back(again)
    assert (again.backend.given, again.robot.given, again.model.given) == (
        [WHOLE["backend"]],
        [WHOLE["robot"]],
        [WHOLE["model"]],
    )


def test_a_real_robot_only_learns_and_a_world_is_not_put_there(tmp_path: Path) -> None:
    keep_checkpoint(tmp_path, prepared(simulated=False, backend=None), False, SUCCESS, "x")
    kept, real, world = load_checkpoint(tmp_path), prepared(simulated=False), prepared()
    assert kept is not None
    kept.put_back(real)
    assert (real.backend.given, real.robot.given, real.model.given) == ([], [], [WHOLE["model"]])
    with pytest.raises(NotAState, match="it holds no world"):
        kept.put_back(world)
    assert world.model.given == []


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"more": 1}, "no checkpoint of the format handcart-checkpoint/8"),
        ({"time_s": "late"}, "its time is not a number"),
        ({"time_s": 2}, "its time is not a number"),
        ({"after": None}, "its time is not a number"),
        ({"result": {"outcome": "Success"}}, "1 validation error"),
        ({"format": "x" * 60}, "'" + "x" * 40 + "', which another version"),
    ],
)
def test_what_is_no_checkpoint_is_refused(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    (tmp_path / CHECKPOINT_FILE).write_bytes(pack({**WHOLE, **change}))
    with pytest.raises(NotAState, match=words):
        load_checkpoint(tmp_path)


def test_a_list_is_no_checkpoint(tmp_path: Path) -> None:
    (tmp_path / CHECKPOINT_FILE).write_bytes(pack([1, 2]))
    with pytest.raises(NotAState, match="no checkpoint of the format"):
        load_checkpoint(tmp_path)
