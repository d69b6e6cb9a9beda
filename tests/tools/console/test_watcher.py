"""The list of runs that the console shows."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.networks.run_files.socket_path import CONTROL_SOCKET
from handcart.tools.console import watcher as module
from handcart.tools.console.watcher import Watcher


def test_an_older_run_that_may_be_running_is_shown(
    ran: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("newest", "older", "oldest"):
        shutil.copytree(ran, tmp_path / name, ignore=shutil.ignore_patterns("control*"))
    (tmp_path / "oldest" / CONTROL_SOCKET).touch()
    monkeypatch.setattr(module, "MAX_SHOWN_RUNS", 1)
    watcher = Watcher(tmp_path)
    try:
        assert list(watcher._list()) == ["newest", "oldest"]
    finally:
        watcher.close()
