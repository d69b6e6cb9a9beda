"""pytest plugin that notes which test executes which line, and how long each test takes.

`python scripts/mutation --record FILE` runs the suite with it. Only files that mutants are drawn from are
traced.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Generator
from pathlib import Path

import pytest
from coverage import Coverage
from drawing import MODULE_GROUPS
from recording import DURATIONS_SUFFIX, FILE_VARIABLE


class Recorder:
    """Coverage with one context per test: its node id."""

    def __init__(self, file: Path, project: Path) -> None:
        folders = [f"{project}/{folder}/*" for folders in MODULE_GROUPS.values() for folder in folders]
        self._file, self._durations = file, dict[str, float]()
        self._coverage = Coverage(str(file), data_suffix=True, include=folders, config_file=False)
        self._coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Trace one test with its fixtures."""
        begun = time.monotonic()
        self._coverage.switch_context(item.nodeid)
        try:
            return (yield)
        finally:
            self._coverage.switch_context("")
            self._durations[item.nodeid] = time.monotonic() - begun

    def pytest_unconfigure(self) -> None:
        """Save both files."""
        self._coverage.stop()
        self._coverage.save()
        path = self._file.with_name(f"{self._file.name}{DURATIONS_SUFFIX}.{os.getpid()}")
        path.write_text(json.dumps(self._durations), encoding="utf-8")


def pytest_configure(config: pytest.Config) -> None:
    """Begin in each process that runs tests."""
    config.pluginmanager.register(Recorder(Path(os.environ[FILE_VARIABLE]), config.rootpath), "contexts")
