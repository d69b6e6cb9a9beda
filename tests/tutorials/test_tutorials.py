"""Tutorials work as pasted: their files are written and their commands run, in order, in an empty folder.

A block with a caption is a file. A command whose line ends in `# status N` exits with N.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.tutorials.tutorial_steps import TUTORIALS, carry_out, steps, write_file


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS)
def test_tutorial_works_as_pasted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str) -> None:
    monkeypatch.chdir(tmp_path)
    done = 0
    running: list[subprocess.Popen[bytes]] = []
    try:
        for path, text in steps(page):
            if path:
                write_file(tmp_path, path, text)
                continue
            status, expected = carry_out(text, tmp_path, monkeypatch, running)
            assert status == expected, text
            done += 1
    finally:
        for process in running:
            process.kill()
            process.wait()
    assert done >= 3
