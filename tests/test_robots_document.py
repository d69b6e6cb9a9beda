"""The commands of docs/how_to/robots.md work as written."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from handcart.tools.main import main

pytest.importorskip("pybullet_data", reason="the example's arm comes with PyBullet")

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "docs" / "how_to" / "robots.md").read_text(encoding="utf-8")
LONG = ("campaign", "--backend")  # covered by other tests


def commands() -> list[list[str]]:
    blocks = re.findall(r"```bash\n(.*?)```", TEXT, re.S)
    return [shlex.split(line) for block in blocks for line in block.splitlines()]


@pytest.mark.slow
def test_every_command_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("tasks", "backends"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    done = 0
    for program, *words in commands():
        if program == "cp":
            _, source, target = words
            shutil.copytree(source, target)
        elif program == "handcart" and not set(LONG) & set(words):
            with pytest.raises(SystemExit) as end:
                main(words)
            assert not end.value.code, words
            done += 1
    assert done == 9
    assert (tmp_path / "my_robot.svg").is_file()


def test_the_example_shown_is_the_example() -> None:
    """The first one is of the robot that the page builds; the others are of makers' robots."""
    shown = re.findall(r"```yaml\n(.*?)```", TEXT, re.S)[:1]
    robot = (ROOT / "backends" / "robots" / "xarm_cart" / "robot.yaml").read_text(encoding="utf-8")
    assert shown
    assert all(block in robot for block in shown)
