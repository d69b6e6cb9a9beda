"""CPU time of `handcart check` on networks of 100, 1,200 and 10,000 situations with probabilities:
`python -m benchmarks.deciding.sizes`.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

LIMITS_S = {100: 5.0, 1_200: 6.0, 10_000: 20.0}
TASK_HEADER = "format: handcart-task/1\ntitle: forward\nrobot: librarian\nworld: world.yaml\nstart: s0\n"
WORLD_FOLDER = Path(__file__).parents[2] / "tasks" / "return_book"
"""Folder of the world that the networks are checked in."""


def task_lines(count: int, seed: int, least_p: float, person_s: float) -> Iterator[str]:
    """Yield a task file with two actions out of each situation, one to four situations forward."""
    draws = random.Random(seed)
    yield f"{TASK_HEADER}goal: s{count - 1}\nperson_s: {person_s}\nsituations:\n"
    yield from (f"  s{number}: {{}}\n" for number in range(count))
    yield "actions:\n"
    for here in range(count - 1):
        for _ in range(2):
            there = min(count - 1, here + draws.randint(1, 4))
            p, give_up = draws.uniform(least_p, 0.98), draws.choice([0.0, 0.0, 0.01])
            cost = f"cost_s: {draws.uniform(1.0, 60.0):.1f}, p: {p:.3f}, p_give_up: {give_up}"
            yield f"  - {{do: MODIFY, from: s{here}, to: s{there}, {cost}, with: {{place: home}}}}\n"


def main() -> None:
    """Print a line for each size."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.sizes", description=__doc__)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--least-p", type=float, default=0.6, help="least probability of Success")
    words.add_argument("--person-s", type=float, default=600.0)
    words.add_argument("--sizes", type=int, nargs="*", default=list(LIMITS_S))
    given = words.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name in ("world.yaml", "map.yaml", "map.png", "catalogue.yaml"):
            shutil.copy(WORLD_FOLDER / name, folder)
        for count in given.sizes:
            path = Path(folder) / f"forward_{count}.yaml"
            path.write_text("".join(task_lines(count, given.seed, given.least_p, given.person_s)))
            print(f"{count} situations ...", flush=True)
            _measure(path, count)


def _measure(path: Path, count: int) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "handcart", "check", str(path), "--json"]
    said = subprocess.run(command, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    found = json.loads(said.stdout)["policies"]
    limit = f" (allowed: {LIMITS_S[count]:g} s)" if count in LIMITS_S else ""
    print(f"  {cpu:.1f} s CPU{limit}")
    for item in (found["rule"], found["best"]):
        goal = f"P(goal) [{item['p_goal']:.5f}, {item['p_goal_high']:.5f}]"
        print(f"  {item['policy']}: {goal}, price [{item['price_s']:.1f}, {item['price_high_s']:.1f}] s")
    print(f"  no policy costs less than {found['least_price_low_s']:.1f} s", flush=True)


if __name__ == "__main__":
    main()
