"""`--version`, and what shells complete."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.tools.conftest import Said

PROGRAM = Path(sys.executable).with_name("handcart")


def asked(**words: str) -> str:
    """Return the program's answer to a shell."""
    environment = {**os.environ, **words}
    said = subprocess.run(
        [PROGRAM], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert said.stderr == ""
    return said.stdout


def test_the_version_is_told(handcart: Callable[..., Said]) -> None:
    said = handcart("--version")
    assert said.status == 0
    assert said.out.split()[:2] == ["handcart", version("handcart")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "offered"), [("handcart con", "console"), ("handcart run --no-re", "--no-report")]
)
def test_shells_complete_commands_and_options(typed: str, offered: str) -> None:
    count = str(len(typed.split()) - 1)
    assert offered in asked(_HANDCART_COMPLETE="complete_bash", COMP_WORDS=typed, COMP_CWORD=count).split()
    assert offered in asked(_HANDCART_COMPLETE="complete_zsh", _TYPER_COMPLETE_ARGS=typed)
    fish = {"_TYPER_COMPLETE_ARGS": typed, "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    assert offered in asked(_HANDCART_COMPLETE="complete_fish", **fish)


@pytest.mark.slow
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_gets_a_script(shell: str) -> None:
    assert "_HANDCART_COMPLETE" in asked(_HANDCART_COMPLETE=f"source_{shell}")
