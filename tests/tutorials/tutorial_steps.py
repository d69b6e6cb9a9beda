"""Files and commands of a tutorial's page, and how a test carries them out as a reader would."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
TUTORIALS = sorted(page.name for page in FOLDER.glob("*.md") if page.name != "index.md")
BLOCK = re.compile(
    r"```(?:\{code-block\} \w+\n:caption: (?P<file>\S+)\n\n?|(?P<kind>bash)\n)(?P<text>.*?)```", re.S
)
INSTALL = ("pip", "install", "-e")
RUN_BEGIN_TIMEOUT_S = 60.0


def steps(page: str) -> Iterator[tuple[str, str]]:
    """Yield the files and commands of a page: (path, text) of a file, ("", line) of a command."""
    for block in BLOCK.finditer((FOLDER / page).read_text(encoding="utf-8")):
        if block["file"]:
            yield block["file"], block["text"]
        else:
            yield from (("", line) for line in block["text"].splitlines() if line.strip())


def write_file(folder: Path, path: str, text: str) -> None:
    """Write a file that a page shows."""
    (folder / path).parent.mkdir(parents=True, exist_ok=True)
    (folder / path).write_text(text, encoding="utf-8")


def carry_out(
    line: str, folder: Path, monkeypatch: pytest.MonkeyPatch, running: list[subprocess.Popen[bytes]]
) -> tuple[int, int]:
    """Run a command line in a folder; return its exit status and the status that the page states.

    `handcart` runs in this process; `python` and `pytest` are programs of this environment. `pip install -e
    FOLDER` installs a package of the page into a folder `site`, which this process and later ones see. A run
    that the page puts into the background (`&`) is added to `running`, and has asked for permission when the
    next command begins; `kill -9 $!` ends the last of these.
    """
    line, _, expected = line.partition(" # status ")
    program, *words = shlex.split(line)
    if words[-1] == "&":
        running.append(_begin(words[:-1]))
        return 0, 0
    if line == "kill -9 $!":
        running[-1].kill()
        return running[-1].wait() and 0, 0
    if program == "handcart":
        return _in_this_process(words), int(expected or 0)
    if (program, *words[:-1]) == INSTALL:
        _install(folder / words[-1], folder / "site", monkeypatch)
        return 0, 0
    start = [sys.executable] if program == "python" else [sys.executable, "-m", program]
    assert program in ("python", "pytest"), line
    return subprocess.run([*start, *words], cwd=folder, check=False).returncode, int(expected or 0)


def _begin(words: list[str]) -> subprocess.Popen[bytes]:
    """Begin a run in the background, and wait until it asks for permission."""
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(
        [sys.executable, "-m", "handcart", *words], stdin=quiet, stdout=quiet, stderr=quiet
    )
    end = time.monotonic() + RUN_BEGIN_TIMEOUT_S
    while not _asks():
        assert process.poll() is None, words
        assert time.monotonic() < end, words
        time.sleep(0.05)
    return process


def _asks() -> bool:
    """Return whether the latest run is alive and waits for permission."""
    from handcart.networks.operator.asking import NotAlive, NotAnswering, ask

    try:
        reply = ask(Path("runs/latest"), {"do": "status"})
    except (NotAlive, NotAnswering, OSError):
        return False
    return bool(reply["ok"] and reply["asks"])


def _install(package: Path, site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from handcart.primitives import registry

    command = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, "--target", str(site), str(package)], check=True)
    monkeypatch.setenv("PYTHONPATH", str(site))
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(registry, "_all", registry._all.__wrapped__)  # as a new process would read them


def _in_this_process(words: list[str]) -> int:
    from handcart.tools.main import main

    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)
