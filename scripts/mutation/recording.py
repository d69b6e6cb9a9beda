"""The recorded run of the suite: which test executes which line, and how long each test takes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from coverage import Coverage, CoverageData

FILE_VARIABLE = "HANDCART_MUTATION_RECORD"
"""Environment variable with the data file; each process of pytest adds a suffix of its own."""
DURATIONS_SUFFIX = ".durations"


def record(project: Path, file: Path, jobs: int, tests: Sequence[str] = ()) -> int:
    """Run the quick suite once and write `file` and `file`.durations; return pytest's exit status."""
    file = file.resolve()
    surroundings = os.environ | {
        FILE_VARIABLE: str(file),
        "PYTHONPATH": os.pathsep.join([str(project / "src"), str(Path(__file__).parent), *sys.path]),
    }
    ignored = ["-W", "ignore::coverage.exceptions.CoverageWarning"]
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "-p", "recorder", *ignored, *tests]
    status = subprocess.run(command, cwd=project, env=surroundings, check=False).returncode
    _combine(file)
    return status


def _combine(file: Path) -> None:
    """Join what the processes wrote."""
    durations: dict[str, float] = {}
    for part in sorted(file.parent.glob(f"{file.name}{DURATIONS_SUFFIX}.*")):
        durations |= json.loads(part.read_text(encoding="utf-8"))
        part.unlink()
    whole = durations_of(file)
    whole.write_text(json.dumps(durations), encoding="utf-8")
    parts = [part for part in file.parent.glob(f"{file.name}.*") if not part.name.startswith(whole.name)]
    joined = Coverage(str(file), config_file=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        joined.combine([str(part) for part in parts])
    joined.save()


def durations_of(file: Path) -> Path:
    """Return the file with the durations that belongs to a data file."""
    return file.with_name(file.name + DURATIONS_SUFFIX)


@dataclass(frozen=True)
class Recording:
    """Recorded run of the suite: which test executes which line."""

    data: CoverageData
    durations: dict[str, float]
    """Node id: time that the test took, in [s]."""

    @cached_property
    def _known(self) -> dict[str, dict[int, list[str]]]:
        return {}

    def tests_of(self, file: str) -> dict[int, list[str]]:
        """Return, for each line of a file, the node ids of the tests that execute it."""
        if file not in self._known:
            path = next(
                (
                    measured_file
                    for measured_file in self.data.measured_files()
                    if measured_file.endswith(f"/{file}")
                ),
                None,
            )
            self._known[file] = self.data.contexts_by_lineno(path) if path else {}
        return self._known[file]


def read_recording(file: Path | None) -> Recording | None:
    """Read what `record` wrote."""
    if file is None:
        return None
    data = CoverageData(str(file))
    data.read()
    durations = json.loads(durations_of(file).read_text(encoding="utf-8"))
    return Recording(data, durations)
