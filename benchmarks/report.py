"""Measure the cost of a run's page: `python -m benchmarks.report RUN...` prints its size and CPU time."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import orjson

from handcart.evaluation.viewing.report.report import write_report


def main() -> None:
    """Print a line for each run's folder."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("runs", nargs="+", type=Path, help="folders of runs")
    runs: list[Path] = words.parse_args().runs
    with TemporaryDirectory() as there:
        for folder in runs:
            spent = []
            for _ in range(5):
                before = time.process_time()
                page = write_report(folder, Path(there) / "report.html")
                spent.append(time.process_time() - before)
            took = orjson.loads((folder / "summary.json").read_bytes())["wall_time_s"]
            size, least = page.stat().st_size / 1e6, min(spent)
            share = 100.0 * least / took
            print(
                f"{folder.name}: {size:.2f} MB, {least:.3f} s of CPU (first {spent[0]:.3f} s), "
                f"{share:.2f} % of the run's {took:.1f} s"
            )


if __name__ == "__main__":
    main()
