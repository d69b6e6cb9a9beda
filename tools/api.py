"""The Python API, `import handcart`: the commands as functions for scripts and notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import orjson

from handcart.files.errors import FileError, Finding, InputError
from handcart.tasks.task_names import task_path

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
    from handcart.evaluation.conformance.report import KitReport
    from handcart.networks.past_runs.past_run import PastAction
    from handcart.networks.task.task_file import Task

Settings = Mapping[str, Any]
"""Values of a task's parameters, by name: text as after `--set NAME=`, or numbers, lists and so on."""


@dataclass(frozen=True)
class Result:
    """Result of a run that has ended, with its actions and metrics."""

    summary: Mapping[str, Any]
    """Content of the run's `summary.json`."""
    status: int
    """Exit status that `handcart run` would have."""
    actions: tuple[PastAction, ...]
    """Actions that were started, in order, each with its outcome."""

    @property
    def outcome(self) -> str:
        """Outcome of the run, which is Success, Fail, GiveUp, Cancelled or Error."""
        return str(self.summary["outcome"])

    @property
    def situation(self) -> str:
        """Name of the situation of the action network in which the run ended."""
        return str(self.summary["situation"])

    @property
    def reason(self) -> str:
        """Reason why the run did not succeed; empty for a Success."""
        return str(self.summary["reason"])

    @property
    def metrics(self) -> Mapping[str, Any]:
        """Measured values of the run by name; on simulated backends also values from the ground truth."""
        metrics: Mapping[str, Any] = self.summary["metrics"]
        return metrics

    @property
    def folder(self) -> Path:
        """The run's folder, with its journal and pictures."""
        return Path(self.summary["run_dir"])

    def _repr_html_(self) -> str:
        """Return the run as an HTML table for notebooks."""
        head = f"<b>{escape(self.outcome)}</b> in situation {escape(self.situation)}"
        if self.reason:
            head += f": {escape(self.reason)}"
        rows = "".join(
            f"<tr><td>{action.number}</td><td>{escape(action.do)}</td><td>{escape(action.source)}</td>"
            f"<td>{escape(action.target)}</td><td>{action.end - action.start:.1f}</td>"
            f"<td>{escape(action.outcome)}</td><td>{escape(action.reason)}</td></tr>"
            for action in self.actions
        )
        names = "".join(f"<th>{name}</th>" for name in ("", "do", "from", "to", "s", "outcome", "reason"))
        return f"<p>{head}</p><table><tr>{names}</tr>{rows}</table>"


@dataclass(frozen=True)
class FileCheck:
    """Results of checking the file of a task, robot or other kind, before anything moves."""

    findings: tuple[Finding, ...]
    """Faults of the file, each with its place."""
    warnings: tuple[str, ...]
    facts: Mapping[str, Any]
    """Other fields of `handcart check --json`; empty if the file cannot be read."""

    @property
    def ok(self) -> bool:
        """True if the file has no faults."""
        return not self.findings


def run(
    task: Path | str,
    *,
    backend: str | None = None,
    seed: int = 0,
    robot: str | None = None,
    set: Settings | None = None,
    runs: Path | str = "runs",
    errors: bool = True,
    permit: Literal["ask", "always", "never"] = "ask",
) -> Result:
    """Run a task once to its end, and return the result.

    Args:
        task: path of the task's file, or name of a task.
        backend: another backend than the task names.
        seed: seed of the simulated errors.
        robot: another robot than the task names: name of a shipped robot, or path of a robot's file.
        set: parameters of the task.
        runs: folder in which the run's folder is made.
        errors: True to simulate the errors of the robot's sensors and drives.
        permit: rule for actions with `permit: operator`. With `ask`, the run waits until the operator answers
            with `handcart permit` or `handcart refuse`.

    Raises:
        FileError: the task or a file that it names is wrong; nothing has moved.
        HandcartError: the task cannot be run for another reason; the message states it.
    """
    from handcart.evaluation.trials.running import run_task
    from handcart.networks.operator.permits import Permits
    from handcart.networks.past_runs.action_log import ActionLog
    from handcart.networks.runs.run_options import RunOptions

    log = ActionLog()
    summary, status = run_task(
        task_path(task),
        Path(runs),
        RunOptions(
            backend,
            _words(set, robot),
            seed,
            errors=errors,
            draw=True,
            checkpoints=True,
            permits=Permits(permit),
            observers=(log,),
        ),
    )
    return Result(summary, status, tuple(log.actions))


def check(file: Path | str, *, set: Settings | None = None) -> FileCheck:
    """Read a file with all files that it names, and return what is wrong with them; nothing moves.

    Args:
        file: path of a task's, a robot's or another file, or the name of a task or robot.
        set: parameters of a task, checked as values of its file.

    Returns:
        Faults (`findings`), warnings and facts. For a file that cannot be read, the reason is among the
        findings.
    """
    from handcart.tools.commands.check_file import file_facts

    try:
        facts = file_facts(Path(file), _words(set, None))
    except FileError as error:
        return FileCheck(tuple(error.findings), (), {})
    except InputError as error:  # a name that no file's line is known for
        return FileCheck((Finding(str(file), 1, 1, str(error)),), (), {})
    shown = ("errors", "warnings", "lines", "grouped")
    rest = {key: value for key, value in facts.items() if key not in shown}
    return FileCheck(tuple(facts.get("errors", ())), tuple(map(str, facts.get("warnings", ()))), rest)


def load_task(file: Path | str, *, set: Settings | None = None) -> Task:
    """Read a task's file and its action network.

    Args:
        file: path of the task's file, or name of a task.
        set: parameters of the task, in place of those of its file.

    Raises:
        FileError: the task has faults; the error contains all of them.
    """
    from handcart.networks.task import task_file

    return task_file.load_task(task_path(file), _words(set, None))


def campaign(
    task: Path | str,
    *,
    trials: int = 20,
    first: int = 0,
    jobs: int | None = None,
    backend: str | None = None,
    robot: str | None = None,
    set: Settings | None = None,
    generate: Sequence[str] = (),
    out: Path | str | None = None,
    shard: str | None = None,
    cluster: str | None = None,
    until: str | None = None,
    vary: Path | str | None = None,
    faults: Path | str | None = None,
    level: Literal["run", "fitted", "network"] = "run",
    learned_from: Sequence[Path | str] = (),
    rare: Literal["Success", "Fail", "GiveUp"] | None = None,
    importance: Literal["fails", "attempts"] | None = None,
    population: int | None = None,
    report: bool = True,
    runs: Path | str | None = None,
) -> CampaignReport:
    """Run seeded trials of a task in parallel, and count how they end.

    Args:
        task: path of the task's file, or name of a task.
        trials: number of trials.
        first: seed of the first trial.
        jobs: number of parallel processes; with more than one, a script needs `if __name__ == "__main__":`.
            None: 2, or 1 if `level` is not `run`.
        backend: another backend than the task names.
        robot: another robot than the task names, a shipped robot's name or the path of a robot's file.
        set: parameters of the task.
        generate: generator of a world for each seed and its options, `NAME` or `NAME.KEY=VALUE` each.
        out: folder of the campaign, in which each trial is kept; the same call continues an unfinished
            campaign.
        shard: `K/N`: the K-th of N parts, for `handcart campaign merge`.
        cluster: address of a Dask scheduler whose workers run the trials, or the path of its file.
        until: claim about the success rate, such as `p > 0.95`; the campaign ends as soon as it is decided.
        vary: file of numbers that vary by trial (docs/how_to/campaigns.md).
        faults: file of injected faults (docs/how_to/campaigns.md).
        level: `run`: each trial is a run of the robot; `network`: no robot moves, and outcomes are drawn from
            each action's probability `p`; `fitted`: outcomes are drawn as observed in other campaigns.
        learned_from: folders of the campaigns from which `fitted` takes outcomes.
        rare: rare outcome whose probability is estimated. Each trial is then a population of runs;
            `RareEstimate.of` in `handcart.evaluation.campaigns.rare.rare_estimate` computes the estimate.
        importance: with `rare`, the measure of how near a run is to the rare outcome: its number of Fails, or
            the attempts of one action.
        population: with `rare`, number of runs of a population.
        report: True to write `report.html` into the folder.
        runs: folder in which the runs' folders are made; None: `runs`, in the campaign's folder if it has
            one.

    Raises:
        KeyboardInterrupt: the user ended the campaign.
        InputError: an argument is invalid, as the message states; nothing has moved.
        HandcartError: a trial cannot be run or stored, as the message states.
    """
    from handcart.evaluation.campaigns.data.trial_log import TrialFile
    from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
    from handcart.tools.campaigns.asked_campaign import AskedCampaign

    asked = AskedCampaign(
        task=task_path(task),
        trials=trials,
        first=first,
        backend=backend,
        settings=_words(set, robot),
        generate=generate,
        out=_path(out),
        shard=shard,
        until=until,
        vary=_path(vary),
        faults=_path(faults),
        level=level,
        learned_from=tuple(map(Path, learned_from)),
        runs=_path(runs),
        rare=rare,
        importance=importance,
        population=population,
    )
    with asked.opened() as opened:
        for _ in opened.run(jobs, cluster):
            pass
        found = opened.report()
        if out is None and isinstance(found.trials, TrialFile):  # which is gone at the end
            found = CampaignReport(tuple(found.trials), found.holds)
        if report:
            opened.write_page(found)
        return found


def conformance(
    backend: str = "kinematic",
    *,
    robot: str = "librarian",
    quick: bool = True,
    parts: Sequence[str] = (),
    jobs: int = 2,
) -> KitReport:
    """Test whether backend, robot and primitives keep their contracts (docs/how_to/conformance.md).

    Args:
        backend: name of the backend.
        robot: name of a robot, or path of its file.
        quick: True for few faults and no complete tasks; False for everything.
        parts: any of `checks`, `faults`, `mutants` and `tasks` (default: all, but no `tasks` if `quick`).
        jobs: number of parallel processes.
    """
    from handcart.evaluation.conformance.kit import KitSetting, run_kit

    return run_kit(KitSetting(backend, robot, quick, parts), jobs)


def _words(settings: Settings | None, robot: str | None) -> dict[str, str]:
    """Return the settings as on the command line; JSON is YAML."""
    words = {
        name: value if isinstance(value, str) else orjson.dumps(value).decode()
        for name, value in (settings or {}).items()
    }
    return words if robot is None else {**words, "robot": robot}


def _path(given: Path | str | None) -> Path | None:
    return None if given is None else Path(given)
