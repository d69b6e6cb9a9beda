"""`handcart campaign`: one task, many seeds."""

from __future__ import annotations

import sys
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from handcart.evaluation.campaign_report.campaign_report import CampaignReport
    from handcart.evaluation.campaign_report.claim import Settling
    from handcart.evaluation.campaigns.campaign_setting import CampaignSetting, Level, WorldGenerator
    from handcart.evaluation.campaigns.trial_log import TrialLog
    from handcart.evaluation.campaigns.variation import Variation


def campaign(
    task: Annotated[Path, typer.Argument(help="the task's file")],
    trials: Annotated[int, typer.Option(min=1, help="how many")] = 20,
    first: Annotated[int, typer.Option(help="the first trial's seed")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="processes side by side; otherwise 2, on the network 1")
    ] = None,
    backend: Annotated[str | None, typer.Option(help="another backend than the task names")] = None,
    robot: Annotated[
        str | None, typer.Option(help="another robot than the task names, or the path of its file")
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
    generate: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME or NAME.KEY=VALUE: a generated world for each seed, such as library.blocked=way_around"
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="the campaign's folder: each trial is kept there, and the same command goes on"),
    ] = None,
    shard: Annotated[
        str | None, typer.Option(help="K/N: the K-th of N parts, for `handcart campaign merge`; needs --out")
    ] = None,
    until: Annotated[
        str | None, typer.Option(help='"p > 0.95": end when it is sure whether that holds; 3 where not')
    ] = None,
    junit: Annotated[Path | None, typer.Option(help="also write the trials as JUnit XML")] = None,
    vary: Annotated[
        Path | None, typer.Option(help="a file of numbers in task, robot or world that vary by trial")
    ] = None,
    faults: Annotated[
        Path | None, typer.Option(help="a file of faults that come in each simulated trial")
    ] = None,
    level: Annotated[
        str, typer.Option(help="run, or network: no robot, outcomes are drawn by each action's `p`")
    ] = "run",
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
    runs: Annotated[
        Path | None, typer.Option(help="where the runs' folders are made; otherwise runs, or OUT/runs")
    ] = None,
) -> None:
    """Run seeded trials of a task side by side, and count how they end."""
    from handcart.evaluation.campaign_report.campaign_report import CampaignReport
    from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
    from handcart.files.models.settings import split_setting
    from handcart.tools.terminal.campaign_words import CampaignWords

    words = [*(settings or []), *([f"robot={robot}"] if robot else [])]
    chosen = dict(split_setting(each) for each in words)
    world = _worlds(generate) if generate else None
    setting = CampaignSetting(task, backend, chosen, world, runs or Path("runs"), _level(level, generate))
    seeds = _part(range(first, first + trials), shard, out)
    settling = _settling(until, seeds, shard)
    if vary is not None:
        varied = _variation(vary, setting)
        setting = replace(setting, varied=varied, seeds=range(first, first + trials))
    if faults is not None:
        setting = replace(setting, faults=_faults(faults, setting))
    arguments: dict[str, Any] = {
        "task": str(task),
        "backend": backend,
        "settings": chosen,
        "generate": sorted(generate or []),
        "first": first,
        "trials": trials,
        "level": level,
        "vary_file": None if vary is None else str(vary),
        "vary": None if setting.varied is None else setting.varied.model_dump(mode="json"),
        "faults": None if faults is None else str(faults),
        "until": None if settling is None else str(settling.claim),
        "shard": shard,
    }
    with ExitStack() as stack:
        log = _log(stack, setting, arguments, out)
        if out is not None and runs is None:
            setting = replace(setting, runs=out / "runs")
        interrupted = _run(setting, seeds, jobs or (2 if level == "run" else 1), log, settling)
        counted = log.trials() if settling is None else log.trials()[: settling.count]
        report = CampaignReport(counted)
        told = CampaignWords(report, arguments, interrupted, settling)
        if junit is not None:
            _write_junit(junit, str(task), report, settling)
        if as_json:
            import orjson

            print(orjson.dumps(told.facts()).decode())
        elif report.trials:
            print("\n".join(told.lines()))
        if interrupted:
            sys.exit(130)
        if report.untrue:
            sys.exit(5)
        sys.exit(0 if settling is None or settling.verdict else 3)


def _variation(path: Path, setting: CampaignSetting) -> Variation:
    """What varies, each of it a number in the task's files."""
    from handcart.evaluation.campaigns.variation import load_variation
    from handcart.networks.task.task_file import load_task

    if setting.world is not None:
        raise typer.BadParameter("--vary --generate; allowed: one of them, for a generated world has no file")
    return load_variation(path, load_task(setting.task, setting.settings))


def _faults(path: Path, setting: CampaignSetting) -> Path:
    """The file, read once before anything moves."""
    from handcart.evaluation.campaigns.fault_plan import load_faults

    load_faults(path)
    if setting.level == "network":
        raise typer.BadParameter("--level network --faults; allowed: one of them, a network has no robot")
    return path


def _settling(until: str | None, seeds: Sequence[int], shard: str | None) -> Settling | None:
    from handcart.evaluation.campaign_report.claim import Claim, Settling

    if until is None:
        return None
    if shard is not None:
        raise typer.BadParameter("--until --shard; allowed: one of them, a part alone can't settle it")
    return Settling(Claim.of(until), seeds)


def _write_junit(path: Path, name: str, report: CampaignReport, settling: Settling | None) -> None:
    from handcart.evaluation.campaign_report.junit import write_junit
    from handcart.tools.terminal.writing import NotWritable

    try:
        write_junit(path, name, report.trials, settling)
    except OSError as error:
        raise NotWritable(path, error.strerror) from None


def _level(level: str, generate: list[str] | None) -> Level:
    if level == "run":
        return "run"
    if level != "network":
        raise typer.BadParameter(f"--level {level}; allowed: run, network")
    if generate:
        raise typer.BadParameter("--level network --generate; allowed: one of them, a network has no world")
    return "network"


def _part(seeds: range, shard: str | None, out: Path | None) -> range:
    """The seeds that this process has to do."""
    if shard is None:
        return seeds
    number, _, count = shard.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise typer.BadParameter(f"--shard {shard}; allowed: K/N with K from 1 to N, such as 3/40")
    if out is None:
        raise typer.BadParameter("--shard without --out; needed: the folder for this part")
    return seeds[int(number) - 1 :: int(count)]


def _log(stack: ExitStack, setting: CampaignSetting, arguments: dict[str, Any], out: Path | None) -> TrialLog:
    """Where the trials are kept: in the campaign's folder, or in one that is gone afterwards."""
    import tempfile

    from handcart.evaluation.campaigns.campaign_folder import CampaignFolder
    from handcart.evaluation.campaigns.trial_log import TrialLog

    if out is None:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        return stack.enter_context(TrialLog(Path(folder) / "trials.jsonl", sync=False))
    from importlib.metadata import version

    from handcart.evaluation.campaigns.campaign_files import checksums
    from handcart.networks.task.task_file import load_task

    read = load_task(setting.task, setting.settings)
    arguments |= {"handcart": version("handcart"), "files": checksums(setting, read)}
    return stack.enter_context(CampaignFolder.made(out, arguments).log())


def _run(
    setting: CampaignSetting, seeds: Sequence[int], jobs: int, log: TrialLog, settling: Settling | None
) -> bool:
    """Run what isn't in the log yet, until a claim is settled; whether it was interrupted."""
    from rich.console import Console
    from rich.progress import track

    from handcart.evaluation.campaigns.campaign import run_campaign

    there = len(log)
    if there:
        print(f"{there} of {len(seeds)} trials are there already", file=sys.stderr)
    if settling is not None and any(settling.hear(trial) for trial in log.trials()):
        return False
    running = run_campaign(setting, seeds, jobs, log)
    shown = track(running, "trials", len(seeds) - there, console=Console(stderr=True))
    try:
        with closing(running):
            for trial in shown:
                if settling is not None and settling.hear(trial):
                    break
    except KeyboardInterrupt:
        print(f"interrupted after {len(log)} of {len(seeds)} trials", file=sys.stderr)
        return True
    return False


def _worlds(words: Sequence[str]) -> WorldGenerator:
    """What makes them, of the domain that has worlds of that name."""
    from handcart.files.suggest import suggest
    from handcart.tasks.domain import domains, imported
    from handcart.tools.terminal.typed_model import typed_model

    known = {name: path for domain in domains() for name, path in domain.worlds.items()}
    named = [word.partition(".") for word in words]
    name = named[0][0]
    if other := next((each for each, _, _ in named if each != name), None):
        raise typer.BadParameter(f"--generate {name} and {other}; allowed: worlds of one kind")
    if name not in known:
        raise typer.BadParameter(f"--generate {name}: no worlds of that name{suggest(name, known)}")
    options = [option for _, _, option in named if option]
    worlds: WorldGenerator = typed_model(imported(known[name]), options, f"--generate {name}")
    return worlds
