"""`handcart campaign`: one task, many seeds."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from handcart.evaluation.trials.action_shares import ActionShare
    from handcart.evaluation.trials.campaign import CampaignReport, CampaignSetting, Trial, WorldGenerator


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
    generate: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME or NAME.KEY=VALUE: a generated world for each seed, such as library.blocked=way_around"
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
    runs: Annotated[Path, typer.Option(help="where the runs' folders are made")] = Path("runs"),
) -> None:
    """Run seeded trials of a task side by side, and count how they end."""
    from rich.progress import track

    from handcart.evaluation.trials.campaign import CampaignReport, CampaignSetting, run_campaign
    from handcart.files.models.settings import split_setting

    settings = [*(settings or []), *([f"robot={robot}"] if robot else [])]
    chosen = dict(split_setting(each) for each in settings)
    setting = CampaignSetting(task, backend, chosen, _worlds(generate) if generate else None, runs)
    running = run_campaign(setting, range(first, first + trials), jobs)
    from rich.console import Console

    done: list[Trial] = []
    interrupted = False
    try:
        done.extend(track(running, "trials", trials, console=Console(stderr=True)))
    except KeyboardInterrupt:
        interrupted = True
        print(f"interrupted after {len(done)} of {trials} trials", file=sys.stderr)
    report = CampaignReport(tuple(sorted(done, key=lambda each: each.seed)))
    if as_json:
        _print_json(report, trials, interrupted)
    elif done:
        _print_table(report, setting, generate or ())
    if interrupted:
        sys.exit(130)
    sys.exit(0 if not report.untrue else 5)


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


def _print_table(report: CampaignReport, setting: CampaignSetting, generate: Sequence[str]) -> None:
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
        print(f"  {_rerun(setting, trial.seed, generate)}")


def _shares(report: CampaignReport) -> list[ActionShare]:
    from handcart.evaluation.trials.action_shares import action_shares

    return action_shares(Path(trial.summary["run_dir"]) for trial in report.trials)


def _rerun(setting: CampaignSetting, seed: int, generate: Sequence[str]) -> str:
    chosen = "".join(f" --set {key}={value}" for key, value in (setting.settings or {}).items())
    if not generate:
        return f"handcart run {setting.task} --seed {seed}{chosen}"
    worlds = "".join(f" --generate {each}" for each in generate)
    return f"handcart campaign {setting.task} --trials 1 --first {seed} --jobs 1{worlds}{chosen}"


def _print_json(report: CampaignReport, asked: int, interrupted: bool) -> None:
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
