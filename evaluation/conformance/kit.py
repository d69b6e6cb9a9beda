"""The conformance kit as a whole: its parts, and their processes."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import active_children, get_context
from pathlib import Path

from handcart.evaluation.conformance.checks.all_checks import checks
from handcart.evaluation.conformance.checks.check import CheckResult
from handcart.evaluation.conformance.faults.fail_is_true import Batch
from handcart.evaluation.conformance.faults.forked import Died, Hung, forked
from handcart.evaluation.conformance.faults.rehearsal import Rehearsal, Solo
from handcart.evaluation.conformance.faults.repertoire import declared, left_out, repertoire
from handcart.evaluation.conformance.planted.mutants import Caught, mutants, try_mutant
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.evaluation.trials.rig import RigFiles
from handcart.evaluation.trials.with_parent import end_with_parent
from handcart.networks.task.task_file import load_task

from .report import Broken, KitReport, Result
from .task_runs import OneRun, task_runs

KIT_PARTS = ("checks", "faults", "mutants", "tasks")
QUICK_PARTS = KIT_PARTS[:3]
QUICK_INSTANTS = {"kinematic": (40, 3)}
OTHER_INSTANTS = (10, 1)
"""Numbers of fault instants in each primitive's run: full mode, quick mode."""
MAX_INSTANTS_PER_JOB = 10  # instants of an action that one process sees to at a time, at most
SEEDS, SEEDS_QUICK = 50, 2
"""Numbers of seeds of each shipped task with errors: in full, and quick."""
PROGRESS_PERIOD_S = 10.0  # [s] between two words of how many jobs are done, at most
MAX_JOB_CPU_S = 600.0  # [s] of CPU time that a check or a liar gets


@dataclass(frozen=True)
class KitSetting:
    """Settings of the conformance kit, which tests a backend with a robot, such as selected parts."""

    backend: str
    robot: str = "librarian"
    quick: bool = False
    parts: Sequence[str] = ()
    """Selection from `KIT_PARTS`; empty: all parts, in quick mode without whole tasks."""
    primitives: Sequence[str] = ()
    """Names of the primitives into which faults are injected; empty for all."""
    instants: int | None = None
    """Number of fault instants in each primitive's run; None: the mode's default."""
    seeds: int | None = None
    """Number of seeds of each shipped task; None: the mode's default."""
    only_tasks: Sequence[str] = ()
    """Folder names of the whole tasks to run; empty: all tasks that the robot can do."""
    own_tasks: Sequence[Path] = ()
    """Task files to test with; empty for the tasks that domains declare."""
    simulated: str | None = None
    """Name of the simulated backend behind the drives or topics; None: the backend needs none."""

    @property
    def bench(self) -> KitBench:
        """Return the bench, which creates the tested backend with its robot for each check."""
        return KitBench(self.backend, self.robot, self._files, quick=self.quick, simulated=self.simulated)

    @cached_property
    def _files(self) -> RigFiles:
        """Return the files of the first task made for the robot; a robot without a map has no rig."""
        task = load_task(self.tasks[0], self._chosen) if self.tasks else None
        return RigFiles() if task is None or task.path("knowledge", "map") is None else RigFiles.of(task)

    def batches(self) -> list[Batch]:
        """Return the work of the fault trials as batches, each of which is done in one process.

        The trials inject faults into REACH, a primitive for tests, and into each primitive of the tasks.
        """
        full, quick = QUICK_INSTANTS.get(self.simulated or self.backend, OTHER_INSTANTS)
        count = self.instants or (quick if self.quick else full)
        shares = math.ceil(count / MAX_INSTANTS_PER_JOB)
        return [
            Batch(source, number, count, part, shares)
            for source, number, name in reversed(self._actions)  # the last takes longest to come to
            for part in range(shares)
            if name in self.primitives or not self.primitives
        ]

    def tried(self) -> list[str]:
        """Return the names of the primitives into which the kit can inject faults, such as REACH."""
        return sorted({name for _, _, name in self._actions})

    @cached_property
    def _actions(self) -> list[tuple[Rehearsal | Solo, int, str]]:
        """Action REACH, then the actions of each rehearsal whose primitives no earlier one has."""
        result: list[tuple[Rehearsal | Solo, int, str]] = [(Solo(self.bench, Reach()), 0, Reach.label())]
        for rehearsal in self.rehearsals:
            tried = {name for _, _, name in result}
            actions = enumerate(rehearsal.actions(), start=1)
            result += [(rehearsal, at, action.do) for at, action in actions if action.do not in tried]
        return result

    @cached_property
    def rehearsals(self) -> tuple[Rehearsal, ...]:
        """Descriptions of the runs of the kit's tasks into which faults are injected.

        If an application domain declares settings with which a task's run is shorter, these settings are
        used.
        """
        short = declared()
        return tuple(
            Rehearsal(
                task,
                self.backend,
                settings={**self._chosen, **short.get(task, {})},
                simulated=self.simulated,
            )
            for task in self.tasks
        )

    @cached_property
    def tasks(self) -> tuple[Path, ...]:
        """Files of the tasks for the test, the user's own tasks or those shipped with handcart."""
        if self.own_tasks:
            return tuple(Path(task).resolve() for task in self.own_tasks)
        return repertoire(self.robot, self._chosen, self.simulated or self.backend)

    @cached_property
    def left_out(self) -> dict[str, str]:
        """Primitives of the kit's tasks into which no faults are injected, each with the reason."""
        if self.own_tasks:
            return {}
        backend, tried = self.simulated or self.backend, self.tried()
        tasks = left_out(self.robot, self._chosen, backend)
        return {
            action.do: f"{backend} simulates no {' and no '.join(keys)}"
            for path, keys in tasks.items()
            for action in load_task(path, self._chosen).network.actions
            if action.do not in tried
        }

    def task_runs(self) -> list[OneRun]:
        """Return the runs of complete tasks: without simulated errors, and with errors for several seeds."""
        seeds = self.seeds or (SEEDS_QUICK if self.quick else SEEDS)
        chosen = [task for task in self.tasks if task.parent.name in self.only_tasks or not self.only_tasks]
        return task_runs(chosen, self.backend, seeds, self._chosen, self.simulated)

    @property
    def chosen_parts(self) -> Sequence[str]:
        """Selected parts of the conformance kit; without a selection, the defaults of quick or full mode."""
        return self.parts or (QUICK_PARTS if self.quick else KIT_PARTS)

    @property
    def _chosen(self) -> dict[str, str]:
        by_path = self.robot.endswith((".yaml", ".yml"))
        return {"robot": str(Path(self.robot).resolve()) if by_path else self.robot}


def default_robot(own_tasks: Sequence[Path]) -> str:
    """Return the robot of the first of the user's own tasks, or the kit's default robot if there are none.

    Raises:
        FileError: the task's file is invalid.
    """
    return load_task(own_tasks[0]).robot if own_tasks else KitSetting.robot


@dataclass(frozen=True)
class OneCheck:
    """Job for a worker process that runs one check of the conformance kit on a bench."""

    name: str
    bench: KitBench

    def __str__(self) -> str:
        return f"check {self.name}"

    def __call__(self) -> CheckResult:
        """Run the check in a copy of the process; a hang or a crash is recorded as a violation."""
        check = checks()[self.name]
        try:
            return forked(lambda: check(self.bench), CheckResult, MAX_JOB_CPU_S)
        except Hung:
            return CheckResult(self.name, check.holds, [f"no end after {MAX_JOB_CPU_S:.0f} s of CPU time"])
        except Died as died:
            return CheckResult(self.name, check.holds, [f"the process died: {died}"])


@dataclass(frozen=True)
class OneMutant:
    """Job for a worker process that tests whether the kit finds one mutant (deliberately faulty code)."""

    name: str
    bench: KitBench

    def __str__(self) -> str:
        return f"liar {self.name}"

    def __call__(self) -> Caught:
        """Plant the mutant, and return whether the kit finds it, in a copy of the process."""
        return forked(lambda: try_mutant(self.name, self.bench), Caught, MAX_JOB_CPU_S)


Job = OneCheck | OneMutant | Batch | OneRun


def jobs_of(setting: KitSetting) -> list[Job]:
    """Return the jobs of all selected parts of the kit.

    Their order lets parallel processes end at about the same time.
    """
    parts = setting.chosen_parts
    jobs: list[Job] = list(setting.task_runs()) if "tasks" in parts else []
    jobs += setting.batches() if "faults" in parts else []
    if "mutants" in parts:
        jobs += [OneMutant(name, setting.bench) for name in mutants()]
    if "checks" in parts:
        jobs += [OneCheck(name, setting.bench) for name in checks()]
    return jobs


def run_kit(
    setting: KitSetting,
    processes: int = 2,
    tell: Callable[[int, int], None] = lambda done, count: None,
    results: dict[int, Result] | None = None,
) -> KitReport:
    """Run the conformance kit, which tests a backend with a robot, in a pool of processes.

    Args:
        setting: backend and robot to test, and selected parts of the kit.
        processes: number of parallel processes.
        tell: called after each job, and from time to time, with the numbers of finished and of all jobs.
        results: filled with the result of each job that has ended, by the job's number, also if Ctrl-C cuts
            the kit off; None where the report of the complete kit is enough.
    """
    jobs = jobs_of(setting)
    results = {} if results is None else results
    for ended in _in_processes(jobs, processes):
        results.update(ended)
        tell(len(results), len(jobs))
    return report_of(setting, results)


def report_of(setting: KitSetting, results: Mapping[int, Result]) -> KitReport:
    """Return the report of the results of the kit's jobs, by their numbers."""
    in_order = [results[number] for number in sorted(results)]
    return KitReport.of(setting.backend, setting.robot, setting.quick, in_order)


def _in_processes(jobs: Sequence[Job], processes: int) -> Iterator[dict[int, Result]]:
    """Yield the results of the jobs that have just ended, by number; empty if none has for a while."""
    with ProcessPoolExecutor(processes, get_context("spawn"), _begins) as pool:
        running = {pool.submit(_done, job): number for number, job in enumerate(jobs)}
        try:
            while running:
                over, _ = wait(running, PROGRESS_PERIOD_S, FIRST_COMPLETED)
                ended = {running.pop(item): item for item in over}
                yield {number: _result(jobs[number], future) for number, future in ended.items()}
        except BaseException:  # jobs under way may take minutes
            for child in active_children():
                child.terminate()
            raise


def _done(job: Job) -> Result:
    return job()


def _result(job: Job, ended: Future[Result]) -> Result:
    error = ended.exception()
    return ended.result() if error is None else Broken(str(job), f"{type(error).__name__}: {error}")


def _begins() -> None:
    """Set up each process of the pool."""
    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to the processes as well
    end_with_parent()
    cv2.setNumThreads(1)
