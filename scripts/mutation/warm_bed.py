"""Copy of the project with a warm pytest process beside it."""

from __future__ import annotations

import compileall
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bed import Bed, Plantable
from choosing import ChosenTests

WARM_PYTEST = Path(__file__).with_name("warm_pytest.py")
BATCHES_S = (2.0, 10.0)
"""Recorded durations after which the next batch begins: an early failure saves the imports of later tests."""
CONFIRM_LIMIT_S = 1800.0
UNSOUND = "unsound"


class Answer(NamedTuple):
    """Result of the tests of a mutant."""

    word: str
    """passed, failed, hung, or unsound: the tests did not even pass in time without the mutant."""
    blamed: tuple[str, ...]
    """Tests that failed, died or hung."""
    ran: int
    """Number of tests that began."""


class WarmBed(Bed):
    """Bed whose tests run in forks of one process."""

    def __init__(self, project: Path, folder: Path, durations: Path | None) -> None:
        """Copy `project`; `durations`: file with the recorded durations of tests."""
        super().__init__(project, folder, {})
        compileall.compile_dir(self.root, quiet=2)
        self._durations = durations
        self._processes: dict[Path, subprocess.Popen[str]] = {}

    def try_mutant(self, mutant: Plantable, tests: ChosenTests, seconds: float) -> Answer:
        """Run tests with a mutant planted, up to the first that fails, within about this time."""
        with self._planted(mutant) as compiled:
            code = self._machine_code.with_name("planted") if compiled else self._machine_code
            answer = self._ask(code, tests, seconds)
        if compiled:
            self._end(code)
            shutil.rmtree(code, ignore_errors=True)
            code = self._machine_code
        if answer.word == "failed" and not answer.blamed:
            sound = self._ask(code, tests, seconds)
            if sound.word != "passed":
                return Answer(UNSOUND, (), answer.ran)
        return answer

    def failing(self, tests: Iterable[str]) -> set[str]:
        """Return those of these tests that fail without any mutant."""
        left, failing = [name for name in tests if "::" in name], set[str]()
        while left:
            chosen = ChosenTests([(name, 0.0) for name in left], [])
            answer = self._ask(self._machine_code, chosen, CONFIRM_LIMIT_S, run_all=True)
            failing |= set(answer.blamed)
            if answer.word != "hung" or not answer.blamed or answer.blamed[-1] not in left:
                break
            left = left[left.index(answer.blamed[-1]) + 1 :]
        return failing

    def close(self) -> None:
        """End the processes."""
        for code in list(self._processes):
            self._end(code)

    def _ask(self, code: Path, tests: ChosenTests, seconds: float, run_all: bool = False) -> Answer:
        process = self._processes.get(code) or self._begin(code)
        request = {"batches": _batches(tests.tests), "files": tests.files, "seconds": seconds, "all": run_all}
        assert process.stdin
        assert process.stdout
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        answer = json.loads(process.stdout.readline())
        return Answer(answer["word"], tuple(answer["blamed"]), answer["ran"])

    def _begin(self, code: Path) -> subprocess.Popen[str]:
        surroundings = os.environ | {
            "PYTHONPATH": str(self.root / "src"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "NUMBA_CACHE_DIR": str(code),
        }
        command = [sys.executable, str(WARM_PYTEST), *([str(self._durations)] if self._durations else [])]
        self._processes[code] = subprocess.Popen(
            command,
            cwd=self.root,
            env=surroundings,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        return self._processes[code]

    def _end(self, code: Path) -> None:
        process = self._processes.pop(code)
        process.communicate()  # the end of stdin ends it


def _batches(tests: Sequence[tuple[str, float]]) -> list[list[str]]:
    batches: list[list[str]] = [[] for _ in range(len(BATCHES_S) + 1)]
    total = 0.0
    for name, seconds in tests:
        batches[sum(total >= limit for limit in BATCHES_S)].append(name)
        total += seconds
    return batches
