"""`handcart campaign`: one task, many seeds."""

from __future__ import annotations

import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.statistics.campaign_report import CampaignReport
    from handcart.tools.campaigns.asked_campaign import OpenCampaign
    from handcart.tools.terminal.campaign_words import CampaignWords
    from handcart.tools.terminal.rare_words import RareWords


def campaign(
    task: Annotated[Path, typer.Argument(help="a task's file, or its name (`handcart list tasks`)")],
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
        typer.Option(help="the campaign's folder: each trial is kept there, and the same command continues"),
    ] = None,
    shard: Annotated[
        str | None, typer.Option(help="K/N: the K-th of N parts, for `handcart campaign merge`; needs --out")
    ] = None,
    until: Annotated[
        str | None, typer.Option(help='"p > 0.95": end when it is sure whether that holds; 3 where not')
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(help="tcp://HOST:PORT of a Dask scheduler, or its file: its workers run the trials"),
    ] = None,
    junit: Annotated[Path | None, typer.Option(help="also write the trials as JUnit XML")] = None,
    vary: Annotated[
        Path | None, typer.Option(help="a file of numbers in task, robot or world that vary by trial")
    ] = None,
    faults: Annotated[
        Path | None, typer.Option(help="a file of faults that come in each simulated trial")
    ] = None,
    level: Annotated[
        str,
        typer.Option(
            help="run; or without a robot network, outcomes drawn by each action's `p`, or fitted, as "
            "recorded campaigns show them"
        ),
    ] = "run",
    learned_from: Annotated[
        list[Path] | None, typer.Option(help="the folder of a recorded campaign, for --level fitted")
    ] = None,
    rare: Annotated[
        str | None,
        typer.Option(
            help="GiveUp, Fail or Success: estimate the probability of this rare end; each trial is a "
            "population of runs that are split again and again where they come nearer to it"
        ),
    ] = None,
    importance: Annotated[
        str | None,
        typer.Option(help="with --rare, the measure of nearness: fails of the run (default), or attempts"),
    ] = None,
    population: Annotated[
        int | None, typer.Option(help="with --rare, runs of a population at each level, otherwise 100")
    ] = None,
    report: Annotated[bool, typer.Option(help="whether report.html is written into the folder")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
    runs: Annotated[
        Path | None, typer.Option(help="where the runs' folders are made; otherwise runs, or OUT/runs")
    ] = None,
) -> None:
    """Run seeded trials of a task in parallel, and report how often each outcome occurs."""
    from handcart.files.models.settings import split_settings
    from handcart.tasks.task_names import task_path
    from handcart.tools.campaigns.asked_campaign import AskedCampaign

    words = [*(settings or []), *([f"robot={robot}"] if robot else [])]
    chosen = split_settings(words)
    asked = AskedCampaign(
        task=task_path(task),
        trials=trials,
        first=first,
        backend=backend,
        settings=chosen,
        generate=tuple(generate or ()),
        out=out,
        shard=shard,
        until=until,
        vary=vary,
        faults=faults,
        level=level,
        learned_from=tuple(learned_from or ()),
        runs=runs,
        rare=rare,
        importance=importance,
        population=population,
    )
    with asked.opened() as opened:
        interrupted = _run(opened, jobs, cluster)
        found = opened.report()
        summary = _words(opened, found, interrupted)
        if junit is not None:
            _write_junit(junit, opened, found)
        if as_json:
            import orjson

            print(orjson.dumps(summary.facts()).decode())
        elif found.trials:
            print("\n".join(summary.lines()))
        if report:
            _write_page(opened, found, not interrupted)
        if interrupted:
            sys.exit(130)
        if found.faulty:
            sys.exit(5)
        sys.exit(0 if opened.settling is None or opened.settling.verdict else 3)


def _words(opened: OpenCampaign, found: CampaignReport, interrupted: bool) -> CampaignWords | RareWords:
    if opened.setting.rare is None:
        from handcart.tools.terminal.campaign_words import CampaignWords

        return CampaignWords(found, opened.arguments, interrupted, opened.settling, opened.learned)
    from handcart.tools.terminal.rare_words import RareWords

    return RareWords(found.trials, opened.arguments, interrupted)


def _run(opened: OpenCampaign, jobs: int | None, cluster: str | None) -> bool:
    """Run the missing trials with a progress bar; return True if the user interrupted them.

    Args:
        opened: the checked campaign.
        jobs: parallel processes; None: as in `OpenCampaign.run`.
        cluster: address, or file, of a Dask scheduler whose workers run them instead; None: no cluster.
    """
    from rich.console import Console
    from rich.progress import Progress

    if opened.in_one_process and (cluster is not None or (jobs or 1) > 1):
        words = f"--level {opened.setting.level} without --out and --until counts its walks in this process"
        print(f"{'--cluster' if cluster is not None else '--jobs'} has no effect: {words}", file=sys.stderr)
    there, count = len(opened.log), len(opened.seeds)
    if dropped := opened.log.dropped_bytes:
        words = f"the last line of its log is damaged ({dropped} bytes): its trial is run again"
        print(words, file=sys.stderr)
    if there:
        print(f"{there} of {count} trials are there already", file=sys.stderr)
    try:
        with Progress(console=Console(stderr=True)) as bar, closing(opened.run(jobs, cluster)) as running:
            task = bar.add_task("trials", total=count - there)
            for more in running:
                bar.advance(task, more)
    except KeyboardInterrupt:
        print(f"interrupted after {opened.done} of {count} trials", file=sys.stderr)
        return True
    return False


def _write_junit(path: Path, opened: OpenCampaign, report: CampaignReport) -> None:
    from handcart.evaluation.campaigns.statistics.junit import write_junit
    from handcart.tools.terminal.writing import NotWritable

    try:
        write_junit(path, str(opened.setting.task), report.trials, opened.settling)
    except OSError as error:
        raise NotWritable(path, error.strerror) from None


def _write_page(opened: OpenCampaign, report: CampaignReport, runs: bool) -> None:
    """Write the campaign's page; an error is printed, and does not change how the campaign ended."""
    from handcart.files.printable import printable

    try:
        path = opened.write_page(report, runs)
    except OSError as error:
        print(printable(f"the report of {opened.out} is missing: {error}"), file=sys.stderr)
    else:
        if path is not None:
            print(printable(f"written: {path}"), file=sys.stderr)
