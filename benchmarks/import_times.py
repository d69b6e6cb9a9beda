"""Measure the CPU time of `import handcart` and `handcart --help` beyond a bare Python.

Each is run in processes of its own; printed is the median of their user and system time, less that of
`python -c pass`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from statistics import median

REPEAT_COUNT = 20
MOST_MS = {"import handcart": 60.0, "handcart --help": 150.0}
"""Allowed time of each [ms]."""
TIMED_CODE = {
    "bare": "pass",
    "import handcart": "import handcart",
    "handcart --help": "from handcart.tools.main import main; main(['--help'])",
}


def cpu_ms(words: Sequence[str]) -> float:
    """User and system time of one process, in [ms]."""
    with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{words[-1]!r} ended with status {process.returncode}")
    return 1e3 * (usage.ru_utime + usage.ru_stime)


def beyond_bare_ms(
    repeats: int = REPEAT_COUNT, middle: Callable[[Sequence[float]], float] = median
) -> dict[str, float]:
    """Return the times beyond a bare Python by name [ms]; the three alternate, so that load affects all
    alike.

    With `min` for `middle`, the CPU time that a crowded processor adds is excluded.
    """
    times: dict[str, list[float]] = {name: [] for name in TIMED_CODE}
    for _ in range(repeats):
        for name, code in TIMED_CODE.items():
            times[name].append(cpu_ms([sys.executable, "-c", code]))
    bare = middle(times.pop("bare"))
    return {name: middle(time) - bare for name, time in times.items()}


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for name, took in beyond_bare_ms().items():
        print(f"{name:<16} {took:6.1f} ms, at most {MOST_MS[name]:.0f}")
