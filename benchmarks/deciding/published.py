"""Best policies of published problems, read from task files, against their published optimal values:
`python -m benchmarks.deciding.published`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from handcart.networks.analysis.figures import network_chances
from handcart.networks.deciding.comparison import comparison
from handcart.networks.task.task_file import load_task

from .published_problems import Outcomes, Problem, State, problems

MAX_DIFFERENCE = 1e-9
TASK_HEADER = (
    "format: handcart-task/1\ntitle: {}\nrobot: librarian\nstart: s0\ngoal: goal\npolicy: goal_probability\n"
)


def task_lines(problem: Problem) -> Iterator[str]:
    """Yield a problem as lines of a task file, with a situation for each state that leads to the goal."""
    rows = _explored(problem)
    alive = _alive(problem, rows)
    number = {state: f"s{index}" for index, state in enumerate(state for state in rows if state in alive)}
    yield TASK_HEADER.format(problem.name)
    yield "situations:\n  goal: {}\n  dead: {}\n"
    yield from (f"  {name}: {{}}\n" for name in number.values())
    yield "actions:\n"
    for state, name in number.items():
        for outcomes in rows[state]:
            yield _action(problem, state, name, outcomes, number)


def _explored(problem: Problem) -> dict[State, list[Outcomes]]:
    rows: dict[State, list[Outcomes]] = {}
    ahead = [problem.start]
    while ahead:
        state = ahead.pop()
        if state in rows or problem.is_goal(state):
            continue
        rows[state] = list(problem.actions(state))
        ahead += [to for outcomes in rows[state] for _, to in outcomes]
    return rows


def _alive(problem: Problem, rows: Mapping[State, list[Outcomes]]) -> set[State]:
    """Return the states from which the goal can be reached."""
    before: dict[State, set[State]] = {}
    for state, every in rows.items():
        for outcomes in every:
            for _, to in outcomes:
                before.setdefault(to, set()).add(state)
    ahead = [state for state in before if problem.is_goal(state)]
    found = set(ahead)
    while ahead:
        new = before.get(ahead.pop(), set()) - found
        found |= new
        ahead += new
    return found


def _action(
    problem: Problem, state: State, name: str, outcomes: Outcomes, number: Mapping[State, str]
) -> str:
    ends: dict[str, float] = {}
    for p, to in outcomes:
        if to != state:
            there = "goal" if problem.is_goal(to) else number.get(to, "dead")
            ends[there] = ends.get(there, 0.0) + float(p)
    then = ", ".join(f"{{to: {to}, p: {p!r}}}" for to, p in ends.items())
    tries = ", attempts: unlimited" if len(outcomes) > 1 and state in (to for _, to in outcomes) else ""
    return f"  - {{do: MODIFY, from: {name}, then: [{then}], cost_s: 1{tries}, with: {{place: x}}}}\n"


def main() -> None:
    """Print a line for each problem; status 1 where one is off."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.published", description=__doc__)
    words.add_argument("--folder", type=Path, help="keep the task files there")
    words.add_argument("--only", default="", help="only problems with this in their names")
    given = words.parse_args()
    worst = 0.0
    with tempfile.TemporaryDirectory() as kept:
        for problem in problems():
            if given.only in problem.name:
                worst = max(worst, _measured(problem, given.folder or Path(kept)))
    print(f"largest difference {worst:.1e} (allowed: {MAX_DIFFERENCE:g})")
    raise SystemExit(worst > MAX_DIFFERENCE)


def _measured(problem: Problem, folder: Path) -> float:
    print(f"{problem.name}: writing its file ...", flush=True)
    path = folder / f"{problem.name}.yaml"
    path.write_text("".join(task_lines(problem)))
    begin = time.process_time()
    task = load_task(path)
    loaded = time.process_time()
    found = comparison(task.network, network_chances(task), "goal_probability")
    solved = time.process_time()
    size = f"{len(task.network.situations)} situations, {len(task.network.actions)} actions"
    values = f"rule {found.rule.goal[0]:.9f}, best {found.best.goal[0]:.12f}, published {problem.optimum}"
    times = f"{loaded - begin:.1f} s to read, {solved - loaded:.1f} s to decide"
    off = abs(found.best.goal[0] - float(problem.optimum))
    print(f"  {size}: {values}, off by {off:.1e}; {times} (CPU)", flush=True)
    return off


if __name__ == "__main__":
    main()
