"""Measure the speed of a simulated return_book, camera included.

python -m benchmarks.books.return_book [RUNS]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions

TASK_FILE = Path(__file__).parent.parent.parent / "tasks" / "return_book" / "task.yaml"


def main() -> None:
    """Print the table; the first run, which compiles code and draws textures, has a row of its own."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("runs", nargs="?", type=int, default=5)
    runs = words.parse_args().runs
    print(f"{'run':<8}{'simulated':>12}{'wall':>10}{'CPU':>10}{'times real time':>18}")
    with tempfile.TemporaryDirectory() as folder:
        for number in range(runs + 1):
            wall, cpu = time.perf_counter(), time.process_time()
            summary, _ = run_task(TASK_FILE, Path(folder), RunOptions(seed=number))
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            simulated = summary["sim_time_s"]
            name = "first" if number == 0 else str(number)
            print(f"{name:<8}{simulated:>10.1f} s{wall:>8.2f} s{cpu:>8.2f} s{simulated / wall:>18.1f}")


if __name__ == "__main__":
    main()
