"""`handcart campaign`: one task, many seeds."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.evaluation.trials.action_shares import ActionShare
    from handcart.evaluation.trials.campaign import Report, Setting, Trial


def campaign(
    task: Annotated[Path, typer.Argument(help="the task's file")],
    trials: Annotated[int, typer.Option(min=1, help="how many")] = 20,
    first: Annotated[int, typer.Option(help="the first trial's seed")] = 0,
    jobs: Annotated[int, typer.Option(min=1, help="processes side by side")] = 2,
    backend: Annotated[str | None, typer.Option(help="another backend than the task names")] = None,
    robot: Annotated[
        str | None, typer.Option(help="another robot than the task names, or the path of its file")
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="KEY=VALUE: a parameter that the task declares")
    ] = None,
    library: Annotated[
        list[str] | None,
        typer.Option(help="KEY=VALUE: a generated library for each seed, such as blocked=way_around"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
    runs: Annotated[Path, typer.Option(help="where the runs' folders are made")] = Path("runs"),
) -> None:
    """Run seeded trials of a task side by side, and count how they end."""
    from rich.progress import track

    from handcart.evaluation.books.library_files import Libraries
    from handcart.evaluation.trials.campaign import Report, Setting, run_campaign
    from handcart.files.models.settings import split_setting

    settings = [*(settings or []), *([f"robot={robot}"] if robot else [])]
    chosen = dict(split_setting(each) for each in settings)
    options = _options([split_setting(each) for each in library or []]) if library else None
    setting = Setting(task, backend, chosen, None if options is None else Libraries(options), runs)
    running = run_campaign(setting, range(first, first + trials), jobs)
    from rich.console import Console

    done: list[Trial] = []
    interrupted = False
    try:
        done.extend(track(running, "trials", trials, console=Console(stderr=True)))
    except KeyboardInterrupt:
        interrupted = True
        print(f"interrupted after {len(done)} of {trials} trials", file=sys.stderr)
    report = Report(tuple(sorted(done, key=lambda each: each.seed)))
    if as_json:
        _print_json(report, trials, interrupted)
    elif done:
        _print_table(report, setting)
    if interrupted:
        sys.exit(130)
    sys.exit(0 if not report.untrue else 5)


def _options(pairs: list[tuple[str, str]]) -> dict[str, Any]:
    words: dict[str, Any] = {"true": True, "false": False}
    return {key: words.get(value, value) for key, value in pairs}


def _print_table(report: Report, setting: Setting) -> None:
    low, high = report.wilson
    count = len(report.trials)
    print(f"Success {report.successes} of {count}; by Wilson {100 * low:.1f} to {100 * high:.1f} % (95 %)")
    print(f"outcomes that the ground truth contradicts: {len(report.untrue)} of {count} trials")
    for outcome, times in report.outcomes.most_common():
        print(f"  {times:4d} x {outcome}")
    print(f"\n{'metric':<16}{'trials':>8}{'least':>11}{'median':>11}{'95 %':>11}{'most':>11}")
    for name, each in report.spreads().items():
        print(
            f"{name:<16}{each.count:>8}{each.least:>11.2f}{each.median:>11.2f}{each.most_95:>11.2f}{each.most:>11.2f}"
        )
    print(f"\n{'action':<56}{'attempts':>9}{'p':>7}{'95 %':>15}{'p_give_up':>11}")
    for share in _shares(report):
        low, high = share.wilson
        ends = f"{share.p:>7.3f}{f'{low:.3f} to {high:.3f}':>17}{share.give_up / share.attempts:>9.3f}"
        print(f"{share.action:<56}{share.attempts:>9}{ends}")
    for trial in report.worst():
        print(f"\nseed {trial.seed}: {'; '.join(trial.untrue) or trial.summary['reason'] or 'with Fails'}")
        print(f"  {_rerun(setting, trial.seed)}")


def _shares(report: Report) -> list[ActionShare]:
    from handcart.evaluation.trials.action_shares import action_shares

    return action_shares(Path(trial.summary["run_dir"]) for trial in report.trials)


def _rerun(setting: Setting, seed: int) -> str:
    from handcart.evaluation.books.library_files import Libraries

    chosen = "".join(f" --set {key}={value}" for key, value in (setting.settings or {}).items())
    if not isinstance(setting.world, Libraries):
        return f"handcart run {setting.task} --seed {seed}{chosen}"
    options = "".join(f" --library {key}={value}" for key, value in setting.world.options.items())
    return f"handcart campaign {setting.task} --trials 1 --first {seed} --jobs 1{options}{chosen}"


def _print_json(report: Report, asked: int, interrupted: bool) -> None:
    import orjson

    low, high = report.wilson
    summary = {
        "trials": len(report.trials),
        "asked": asked,
        "interrupted": interrupted,
        "successes": report.successes,
        "wilson": [low, high],
        "untrue": {trial.seed: list(trial.untrue) for trial in report.untrue},
        "outcomes": dict(report.outcomes),
        "metrics": report.spreads(),
        "actions": [
            {
                "action": each.action,
                "attempts": each.attempts,
                "p": each.p,
                "p_wilson": each.wilson,
                "p_give_up": each.give_up / each.attempts,
            }
            for each in _shares(report)
        ],
    }
    print(orjson.dumps(summary, option=orjson.OPT_NON_STR_KEYS).decode())
