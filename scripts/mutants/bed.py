"""A copy of the project in which bugs are planted, one at a time."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, Protocol

FAILED_STATUS = 1  # pytest's exit status where a test failed
NO_TESTS_STATUS = 5  # where none is of the asked kind
QUICK, SLOW = "not slow", "slow"  # marks of tests
TIMED_OUT = -1000  # status where the tests didn't end
PATIENCE_S = 600.0
LEAST_S = 60.0  # that tests of a bug may take, however quick they are without it
MAX_TIME_RATIO = 10.0  # times as long as without it: then they hang, and that is noticed
MAX_MEMORY_BYTES = 4 * 2**30  # [bytes] that the tests of a bug may take, of addresses
IGNORED_FILES = (".git", ".venv", "__pycache__", "*.egg-info", "build", ".*_cache", ".hypothesis")


class Plantable(Protocol):
    """A bug that can be planted in a file."""

    @property
    def file(self) -> str:
        """Path in the project."""

    @property
    def name(self) -> str:
        """What is wrong with it."""

    @property
    def tests(self) -> tuple[str, ...]:
        """Tests that have to notice it, as pytest takes them."""

    def planted(self, content: str) -> str:
        """Return the file's content with the bug."""


class Ended(NamedTuple):
    """End of a run of pytest."""

    status: int
    """Exit status of the process; negative if a signal ended it; or `TIMED_OUT`."""
    output: str


def _bounded() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))


class Bed:
    """A copy of the project, with its tests.

    Machine code that numba keeps is kept outside the copy, and made again after a bug in compiled code: numba
    doesn't see that a function that another one calls has changed.
    """

    def __init__(self, project: Path, folder: Path, took: dict[tuple[str, ...], float]) -> None:
        """Copy `project`, without what was made in it, into `folder`/project.

        `took` is shared by all beds: how long tests take without a bug, in [s].
        """
        self.root, self._machine_code = folder / "project", folder / "numba"
        self._took = took
        made = shutil.ignore_patterns(*IGNORED_FILES)

        def ignored(where: str, names: list[str]) -> set[str]:
            return made(where, names) | ({"runs"} if Path(where) == project else set())

        shutil.copytree(project, self.root, symlinks=True, ignore=ignored)
        if (project.parent / "shared").exists():
            (folder / "shared").symlink_to(project.parent / "shared")

    def passes(self, tests: tuple[str, ...]) -> bool:
        """Return whether the quick tests pass without a planted bug."""
        return self._passes(tests, QUICK)

    def _passes(self, tests: tuple[str, ...], kind: str) -> bool:
        begun = time.monotonic()
        status = self._run(tests, self._machine_code, PATIENCE_S, kind).status
        self._took[*tests, kind] = time.monotonic() - begun
        return status in (0, NO_TESTS_STATUS)

    def notices(self, mutant: Plantable) -> bool:
        """Return whether one of the nearest tests fails, or never ends, with the bug planted.

        The slow ones run where all quick ones pass.
        """
        if self._fails(mutant, QUICK):
            return True
        if not self._fails(mutant, SLOW):
            return False
        if not self._passes(mutant.tests, SLOW):
            raise RuntimeError(f"{mutant.file}: slow tests fail without any bug: {' '.join(mutant.tests)}")
        return True

    def _fails(self, mutant: Plantable, kind: str) -> bool:
        known = self._took.get((*mutant.tests, kind), PATIENCE_S)
        ended = self.run_tests(mutant, min(PATIENCE_S, max(LEAST_S, MAX_TIME_RATIO * known)), kind)
        if ended.status > FAILED_STATUS and ended.status != NO_TESTS_STATUS:
            raise RuntimeError(f"{mutant.file}: {mutant.name}: pytest ends with status {ended.status}")
        return ended.status not in (0, NO_TESTS_STATUS)  # negative: it died, or never ended

    def run_tests(self, mutant: Plantable, patience_s: float, kind: str = QUICK) -> Ended:
        """Run a mutant's tests with the bug planted, up to the first that fails, within this time."""
        with self._planted(mutant) as compiled:
            code = self._machine_code.with_name("planted") if compiled else self._machine_code
            ended = self._run(mutant.tests, code, patience_s, kind)
            shutil.rmtree(self._machine_code.with_name("planted"), ignore_errors=True)
        return ended

    @contextmanager
    def _planted(self, mutant: Plantable) -> Iterator[bool]:
        """Plant a bug; gives whether it is in compiled code."""
        path = self.root / mutant.file
        sound, times = path.read_text(encoding="utf-8"), path.stat()
        path.write_text(mutant.planted(sound), encoding="utf-8")
        try:
            yield "@compiled" in sound
        finally:
            path.write_text(sound, encoding="utf-8")
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def _run(self, tests: tuple[str, ...], machine_code: Path, patience_s: float, kind: str) -> Ended:
        options = ["-q", "-x", "--tb=no", "-p", "no:cacheprovider", "-m", kind]
        command = [sys.executable, "-m", "pytest", *options, *tests]
        surroundings = os.environ | {
            "PYTHONPATH": str(self.root / "src"),
            "NUMBA_CACHE_DIR": str(machine_code),
        }
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "stdin": subprocess.DEVNULL}
        try:
            ended = subprocess.run(  # type: ignore[call-overload]
                command, cwd=self.root, env=surroundings, timeout=patience_s, preexec_fn=_bounded, **pipes
            )
        except subprocess.TimeoutExpired:
            return Ended(TIMED_OUT, "")
        return Ended(int(ended.returncode), ended.stdout.decode(errors="replace"))
