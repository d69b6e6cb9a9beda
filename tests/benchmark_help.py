"""What benchmarks print with `--help`, asked of many at once."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
ASK_EACH = """
import gc, json, os, runpy, sys
import numba, scipy.stats, typer
import handcart.evaluation.trials.running, handcart.evaluation.conformance.kit

def ask(name, to):
    os.dup2(to, 1)
    sys.argv, status = [name, "--help"], 0
    try:
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    except SystemExit as end:
        status = end.code or 0
    sys.stdout.flush()
    os._exit(status)

gc.freeze()

found = {}
for name in sys.argv[1:]:
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        ask(name, write)
    os.close(write)
    with os.fdopen(read) as said:
        text = said.read()
    found[name] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), text
print(json.dumps(found))
"""
"""Program that imports most once and asks each benchmark for its help in a forked process."""


class Help(NamedTuple):
    """Exit status and output of a benchmark that was called with `--help`."""

    status: int
    text: str


def benchmark_helps(names: Iterable[str]) -> dict[str, Help]:
    """Call modules with `--help`; return their exit statuses and outputs by name."""
    words = [sys.executable, "-c", ASK_EACH, *names]
    asked = subprocess.run(words, stdout=subprocess.PIPE, cwd=ROOT, check=True)
    return {name: Help(*load) for name, load in json.loads(asked.stdout).items()}
