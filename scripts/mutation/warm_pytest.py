"""Process that has the heavy libraries imported and forks a child for the tests of each mutant.

Imports of libraries are paid once; the project's own modules are imported by the child, after the mutant was
planted. Reads one request a line from stdin, answers with one line on stdout. `WarmBed` is the other end.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import resource
import select
import signal
import sys
import time
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, TextIO

import pytest

PRELOADED_LIBRARIES = (
    *(
        "numpy",
        "scipy.spatial",
        "scipy.optimize",
        "scipy.ndimage",
        "scipy.stats",
        "scipy.sparse",
        "scipy.linalg",
    ),
    *("cv2", "PIL.Image", "networkx", "pydantic", "ruamel.yaml", "typer", "hypothesis", "pinocchio", "coal"),
    *(
        "mujoco",
        "py_trees",
        "transitions",
        "canopen",
        "can",
        "serial",
        "asyncio",
        "aiohttp.web",
        "skimage.graph",
    ),
    *("multiprocessing.pool", "concurrent.futures", "xdist.plugin", "rapidocr", "rosbags.highlevel", "av"),
)
"""Imported before the first fork, as far as they are installed."""
MAX_MEMORY_BYTES = 4 * 2**30  # [bytes] of addresses for the tests of a mutant
COLLECT_LIMIT_S = 90.0
"""Time without any test: imports and collecting."""
MIN_LIMIT_S = 30.0
"""Time that a test may take, however quick it was when it was recorded; also of a test without a record."""
MAX_SLOWDOWN = 10.0
"""Times as long as recorded: then a test hangs."""
NO_TESTS = 5  # pytest's exit status where it found none
PYTEST_OPTIONS = (
    "-q",
    "--tb=no",
    "--assert=plain",
    "-p",
    "no:cacheprovider",
    "-p",
    "no:faulthandler",
    "--rootdir=.",
)


class ChosenTests:
    """pytest plugin that runs chosen tests in the given order and writes what happens into a pipe."""

    def __init__(self, request: Mapping[str, Any], batch: list[str], pipe: TextIO) -> None:
        self._batch, self._pipe = {name: place for place, name in enumerate(batch)}, pipe
        self._whole, self._known = set(request["files"]), request["durations"]
        self._end_s = request["end_s"]

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep chosen tests, and of files that are given as a whole those without a record."""
        wanted = [item for item in items if item.nodeid in self._batch or self._is_new(item.nodeid)]
        items[:] = sorted(wanted, key=lambda item: self._batch.get(item.nodeid, -1))

    def pytest_runtest_protocol(self, item: pytest.Item) -> bool | None:
        """Announce a test; pass over it where the time is used up."""
        if time.monotonic() > self._end_s:
            item.session.shouldstop = "out of time"
            return True
        limit = max(MIN_LIMIT_S, MAX_SLOWDOWN * self._known.get(item.nodeid, 0.0))
        self._write("begins", item.nodeid, limit * _crowding())
        return None

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Announce a failure."""
        if report.failed:
            self._write("failed", report.nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Announce a file that cannot be imported."""
        if report.failed:
            self._write("failed", report.nodeid)

    def _is_new(self, name: str) -> bool:
        return name.split("::")[0] in self._whole and name not in self._known

    def _write(self, *what: object) -> None:
        self._pipe.write(json.dumps(what) + "\n")
        self._pipe.flush()


def _crowding() -> float:
    """Return how many processes want each processor, at least 1: on a busy machine a test takes longer."""
    return max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))


def main() -> None:
    """Answer requests until stdin ends; the argument is a file with the recorded durations."""
    durations = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")) if len(sys.argv) > 1 else {}
    for name in PRELOADED_LIBRARIES:
        with contextlib.suppress(Exception):
            import_module(name)
    sys.path[0] = os.getcwd()
    sys.dont_write_bytecode = True  # otherwise a mutant's bytecode could be loaded for the next one
    gc.collect()
    gc.freeze()
    for line in sys.stdin:
        request = json.loads(line)
        request |= {"durations": durations, "end_s": time.monotonic() + request["seconds"]}
        sys.stdout.write(json.dumps(_answer(request)) + "\n")
        sys.stdout.flush()


def _answer(request: Mapping[str, Any]) -> dict[str, Any]:
    """Run a request's tests in a child; return how it ended, the tests that failed, and how many ran."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _run(request, os.fdopen(writer, "w"))
    os.close(writer)
    try:
        return _watch(child, reader)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        os.close(reader)


def _run(request: Mapping[str, Any], pipe: TextIO) -> None:
    """Run the batches up to the first failure; never returns."""
    status = 1
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
        nothing = os.open(os.devnull, os.O_RDWR)
        for number in range(3):
            os.dup2(nothing, number)
        status = _run_batches(request, pipe)
    finally:
        os._exit(status)


def _run_batches(request: Mapping[str, Any], pipe: TextIO) -> int:
    once = [] if request["all"] else ["-x"]
    failed = 0
    for number, batch in enumerate(request["batches"]):
        files = dict.fromkeys(
            [name.split("::")[0] for name in batch] + (request["files"] if number == 0 else [])
        )
        if not files:
            continue
        status = int(
            pytest.main([*PYTEST_OPTIONS, *once, *files], plugins=[ChosenTests(request, batch, pipe)])
        )
        failed = failed or (0 if status == NO_TESTS else status)
        if (failed and once) or time.monotonic() > request["end_s"]:
            break
    return failed


def _watch(child: int, reader: int) -> dict[str, Any]:
    """Follow the child to its end, or to a test that takes too long."""
    failed: list[str] = []
    ran, test, rest = 0, "", b""
    limit = time.monotonic() + COLLECT_LIMIT_S * _crowding()
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        while select.select([reader], [], [], 0.0 if ended else 0.05)[0]:
            read = os.read(reader, 65536)
            if not read:
                break
            *lines, rest = (rest + read).split(b"\n")
            for what, name, *more in map(json.loads, lines):
                if what == "failed":
                    failed.append(name)
                else:
                    ran, test, limit = ran + 1, name, time.monotonic() + more[0]
        if ended:
            code = os.waitstatus_to_exitcode(status)
            blamed = failed or ([test] if code and test else [])
            return {"word": "failed" if code else "passed", "blamed": blamed, "ran": ran}
        if time.monotonic() > limit:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return {"word": "hung", "blamed": [*failed, test] if test else failed, "ran": ran}
        time.sleep(0.01)


if __name__ == "__main__":
    main()
