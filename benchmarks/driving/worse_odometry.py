"""Count false outcomes with larger wheel errors: python -m benchmarks.driving.worse_odometry [--seeds N]

Every shipped task runs on simulated wheels whose errors (radius, tread, slip; outdoors the ground's) are 5
times those of the robot's file, while the localizer assumes the file's. Every outcome is compared with the
ground truth, within limits that don't grow with a claim. Prints a row for each task, and each false
outcome with its seed; the status is 1 if there is one. After Ctrl-C it reports on the runs until then,
with status 130.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rich.console import Console
from rich.progress import Progress
from ruamel.yaml import YAML

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.cut_off import CutOff, each_result
from handcart.backends.description.ground_spec import GroundSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.registry import make_backend
from handcart.evaluation.judging.judge import Judge
from handcart.files.models.model import FileModel
from handcart.networks.runs.run import execute
from handcart.networks.runs.run_options import RunOptions
from handcart.networks.task.preparing import Prepared, make_robot, prepare
from handcart.networks.task.task_file import load_task

TASKS_FOLDER = Path(__file__).resolve().parents[2] / "tasks"
WHEEL_ERROR_KEYS = ("wheel_radius_percent", "tread_percent", "slip_percent")
GROUND_ERROR_KEYS = ("scale_percent", "slip_percent", "turn_slip_percent")
ERROR_FACTOR = 5.0


class WorseRun(NamedTuple):
    """End of one run, with its false outcomes."""

    task: str
    seed: int
    outcome: str
    reason: str
    false: tuple[str, ...]
    cpu_s: float


def task_files(words: Sequence[str] = ()) -> list[str]:
    """Return the shipped tasks as paths below `tasks`, those with one of the words in them."""
    found = [path for path in sorted(TASKS_FOLDER.glob("*/*.yaml")) if "handcart-task/" in path.read_text()]
    names = [str(path.relative_to(TASKS_FOLDER)) for path in found]
    return [name for name in names if not words or any(word in name for word in words)]


def worse(part: FileModel, names: tuple[str, ...], times: float) -> FileModel:
    """Return the same part of a file with some of its figures so many times as large."""
    return part.model_copy(update={name: times * getattr(part, name) for name in names})


def worse_robot(spec: RobotFile, times: float) -> RobotFile:
    """Return the robot as it is simulated; the localizer is given `spec` itself."""
    errors = worse(spec.errors, WHEEL_ERROR_KEYS, times)
    return spec.model_copy(update={"errors": errors}).read_in(spec.folder)


def worse_world(world: Path, folder: Path, times: float) -> Path:
    """Return a world's file with worse ground; the file itself where it has none."""
    yaml = YAML(typ="safe")
    content = yaml.load(world.read_text(encoding="utf-8")) if world.suffix == ".yaml" else {}
    if not isinstance(content, dict) or content.get("ground") is None:
        return world
    ground = GroundSpec.model_validate(content["ground"])
    content["ground"] |= {name: times * getattr(ground, name) for name in GROUND_ERROR_KEYS}
    path = folder / world.name
    with path.open("w", encoding="utf-8") as file:
        yaml.dump(content, file)
    return path


def run_worse(name: str, seed: int, times: float = ERROR_FACTOR, backend: str = "kinematic") -> WorseRun:
    """Run a task below `tasks` once."""
    begun = time.process_time()
    with TemporaryDirectory(prefix="worse-odometry-") as made:
        folder = Path(made)
        with _prepared(TASKS_FOLDER / name, seed, times, backend, folder) as prepared:
            judge = Judge(prepared)
            ran = execute(prepared, folder / "run", RunOptions(observers=(judge,)))
    false = tuple(map(str, ran.summary["metrics"]["untrue"]))
    cpu_s = time.process_time() - begun
    return WorseRun(name, seed, ran.end.outcome, str(ran.summary["reason"]), false, cpu_s)


def _prepared(task: Path, seed: int, times: float, backend: str, folder: Path) -> Prepared:
    world = load_task(task).path("world")
    assert world is not None, "shipped tasks name their worlds"
    settings = {"world": str(changed)} if (changed := worse_world(world, folder, times)) != world else {}
    prepared = prepare(task, backend, settings, seed)
    prepared.backend.close()
    spec, start = prepared.robot.spec, prepared.task.knowledge.start
    made = make_backend(backend, worse_robot(spec, times), changed, seed, start)
    return replace(prepared, backend=made, robot=make_robot(prepared.task, made, spec, prepared.model))


def report(runs: list[WorseRun]) -> Iterator[str]:
    """Yield a line for each task, then one for each false outcome, then the sum."""
    for name in sorted({run.task for run in runs}):
        own = [run for run in runs if run.task == name]
        counts = Counter(run.outcome for run in own).most_common()
        ends = ", ".join(f"{count} {end}" for end, count in counts)
        false, cpu = sum(bool(run.false) for run in own), sum(run.cpu_s for run in own) / len(own)
        yield f"{name:<32} {len(own):>3} runs: {ends}; {false} with false outcomes; {cpu:.1f} CPU s a run"
    for run in sorted(runs):
        yield from (f"  {run.task}, seed {run.seed}: {words}" for words in run.false)
    yield f"false outcomes: {sum(len(run.false) for run in runs)} in {len(runs)} runs"


def main() -> int:
    """Print the report, and return the exit status: 1 where an outcome is false or no run ended."""
    chosen = _arguments()
    todo = [
        (name, seed)
        for seed in range(chosen.seed, chosen.seed + chosen.seeds)
        for name in task_files(chosen.task)
    ]
    runs: list[WorseRun] = []
    calls = [(*item, chosen.times, chosen.backend) for item in todo]
    with Progress(console=Console(stderr=True)) as progress, CutOff() as cut:
        bar = progress.add_task("runs", total=len(todo))
        for run in each_result(run_worse, calls, chosen.jobs):
            runs.append(run)
            progress.advance(bar)
            if chosen.verbose:
                progress.console.print(run, markup=False)
    print("\n".join(report(runs)))
    return cut.status(not runs or any(run.false for run in runs))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="the first one")
    parser.add_argument(
        "--task", action="append", default=[], help="only tasks with this in their path; several times"
    )
    parser.add_argument("--times", type=float, default=ERROR_FACTOR, help="as large as the file's errors")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="print each run when it ends")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
