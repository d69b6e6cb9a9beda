"""`handcart learn`: write probabilities and times that campaigns have counted into a task's file."""

from __future__ import annotations

import difflib
import math
import re
import sys
from collections.abc import Iterator, Sequence
from datetime import UTC
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.evaluation.campaigns.learned.entry_counts import EntryCounts, LearnedShare
    from handcart.networks.deciding.posterior import OutcomeCounts, SwitchVerdict
    from handcart.networks.entries.entry import TaskEntry
    from handcart.networks.task.task_file import Task

FILE_WEIGHT = 1000
"""Number of attempts that a probability of the file is worth, if no trial has started its action."""

_P = r"p \d\.\d+ to \d\.\d+"
COUNTED = re.compile(
    rf"\d{{4}}-\d\d-\d\d: \d+ of \d+(?:, {_P}(?:; \w+ \d+(?: \({_P}\))?(?:, \w+ \d+(?: \({_P}\))?)*)?)?"
)
"""Pattern of the comment that an earlier call has written, which a later one replaces."""


def learn(
    campaigns: Annotated[list[Path], typer.Argument(help="folders of campaigns of the task")],
    task: Annotated[
        Path | None, typer.Option(help="the task's file (default: that of the first campaign)")
    ] = None,
    write: Annotated[bool, typer.Option("--write", help="change the task's file")] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="write the changed file there")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Print which probabilities and times of a task differ from recorded campaigns, or write the new values.

    Comments in the task's file are kept.
    """
    from handcart.evaluation.campaigns.data.campaign_folder import TRIALS
    from handcart.evaluation.campaigns.learned.entry_counts import count_entries
    from handcart.evaluation.campaigns.learned.learned import recorded_campaign
    from handcart.networks.task.task_file import load_task
    from handcart.tasks.task_names import task_path
    from handcart.tools.terminal.skipped_trial import with_note
    from handcart.tools.terminal.writing import write_text

    folders = [recorded_campaign(folder) for folder in campaigns]
    file = task_path(str(task or folders[0].arguments["task"]))
    read = load_task(file)
    recorded = (with_note(folder.trials(), folder.folder) for folder in folders)
    found = count_entries(read, chain.from_iterable(recorded))
    date = _date(max((campaign_folder.folder / TRIALS).stat().st_mtime for campaign_folder in folders))
    verdict = _verdict(read, found)
    before = file.read_text(encoding="utf-8")
    after = _changed(before, read, found, date, verdict)
    if as_json:
        _print_json(read, found, verdict)
    else:
        print("\n".join(_table(read, found)))
        print(_switch_words(read, verdict))
        lines = before.splitlines(keepends=True), after.splitlines(keepends=True)
        print("".join(difflib.unified_diff(*lines, str(file), f"{file}, learned")), end="")
    if target := output or (file if write else None):
        write_text(target, after)
        print(f"written to {target}", file=sys.stderr)
    elif not as_json:
        print(f"nothing is changed yet; --write changes {file}, -o FILE writes a copy")


def _date(seconds: float) -> str:
    from datetime import datetime

    return datetime.fromtimestamp(seconds, UTC).date().isoformat()


def _table(task: Task, found: Sequence[EntryCounts]) -> Iterator[str]:
    yield f"{'action':<44}{'attempts':>9}{'p':>8}{'95 %':>17}{'GiveUps':>9}{'mean s':>9}{'95 %':>17}"
    for entry, entry_counts in zip(task.file.actions, found, strict=True):
        name = f"{entry.do} ({entry.source} to {entry.target})"
        counts = entry_counts.counts
        if not counts.attempts:
            yield f"{name:<44}{0:>9}   never started: its values stay"
            continue
        (low, high), (short, long) = entry_counts.p_95, entry_counts.mean_95_s
        p = f"{entry_counts.p:>8.3f}{f'{low:.3f} to {high:.3f}':>17}{counts.give_ups:>9}"
        interval = "-" if math.isnan(short) else f"{short:.1f} to {long:.1f}"
        mean = f"{entry_counts.mean_s:>9.1f}{interval:>17}"
        yield f"{name:<44}{counts.attempts:>9}{p}{mean}"
        yield from _share_rows(entry, entry_counts)


def _share_rows(entry: TaskEntry, each: EntryCounts) -> Iterator[str]:
    """Yield a row for each cause and for each of several results."""
    shares = {name: share for name, share in each.by_cause.items() if name not in each.causes}
    results = (other.result or "usual result" for other in entry.endings)
    yield from (_share_row(name, one) for name, one in zip(results, each.by_result, strict=False))
    for cause, count in sorted({**dict.fromkeys(shares, 0), **each.causes}.items()):
        share = each.by_cause.get(cause)
        yield f"  {cause:<42}{count:>9}" if share is None else _share_row(cause, share)


def _share_row(name: str, share: LearnedShare) -> str:
    low, high = share.p_95
    return f"  {name:<42}{share.seen:>9}{share.p:>8.4f}{f'{low:.3f} to {high:.3f}':>17}"


def _entry_counts(task: Task, found: Sequence[EntryCounts]) -> list[OutcomeCounts] | None:
    """Return the counts of each action of the file; None if one has no trials and no probability."""
    from handcart.networks.deciding.posterior import OutcomeCounts

    counts = []
    for entry, entry_counts in zip(task.file.actions, found, strict=True):
        if entry_counts.counts.attempts or entry.p_success is None:
            counts.append(entry_counts.counts)
            continue
        successes, give_ups = round(entry.p_success * FILE_WEIGHT), round(entry.p_give_up * FILE_WEIGHT)
        counts.append(OutcomeCounts(successes, FILE_WEIGHT - successes - give_ups, give_ups))
    return counts if all(count.attempts for count in counts) else None


def _verdict(task: Task, found: Sequence[EntryCounts]) -> SwitchVerdict | None:
    from handcart.networks.deciding.posterior import judge_switch

    counts = _entry_counts(task, found)
    if counts is None:
        return None
    network = task.network
    name: Any = "goal_probability" if network.policy == "goal_probability" else "expected_cost"
    copies = [None if entry is None else counts[entry] for entry in task.entries]
    return judge_switch(network, copies, name, network.person_s)


def _switch_words(task: Task, verdict: SwitchVerdict | None) -> str:
    if verdict is None:
        return "the policy stays: of some actions no probability is known"
    if verdict.is_same:
        return "the policy stays: the best one decides as the rule does"
    saved = f"by {verdict.saved_s:.1f} s in the mean"
    share = f"better than the rule in {verdict.better_share:.1%} of draws, {saved}"
    if verdict.is_sure:
        return f"policy: the best one is {share}"
    return f"the policy stays {task.network.policy}: the best one is {share}; needed: 95 %"


def _changed(
    text: str, task: Task, found: Sequence[EntryCounts], date: str, verdict: SwitchVerdict | None
) -> str:
    from handcart.tools.terminal.yaml_editing import edited, with_comments

    def change(data: Any) -> None:
        for number, (entry, item) in enumerate(zip(task.file.actions, found, strict=True)):
            if not item.counts.attempts:
                continue
            row = data["actions"][number]
            if entry.route_from is None:  # otherwise cost_s is the part besides the route
                row["cost_s"] = _rounded(item.mean_s, row["cost_s"])
            _write_chances(row, entry, item)
        if verdict is not None and verdict.is_sure and task.network.policy == "rule":
            data.insert(list(data).index("goal") + 1, "policy", "expected_cost")

    counted = {number: f"{date}: {item.words()}" for number, item in enumerate(found) if item.counts.attempts}
    return with_comments(edited(text, change), "actions", counted, COUNTED)


def _write_chances(row: Any, entry: TaskEntry, each: EntryCounts) -> None:
    """Write the probabilities of an action into its row of the file."""
    from handcart.networks.entries.entry import OTHER_CAUSES

    if entry.is_plain:
        row["p"] = each.p
    elif each.by_result:
        for ending, result in zip(row["then"], each.by_result, strict=True):
            ending["p"] = result.p
    else:
        return  # which result each Success had was not recorded
    if each.p_give_up or "p_give_up" in row:
        row["p_give_up"] = each.p_give_up
    chances = {name: share.p for name, share in each.by_cause.items()} or _kept_shares(entry, each)
    for cause, p in chances.items():
        row["on_fail"][cause] = _with_p(row["on_fail"][cause], p)
    other = row["on_fail"].get(OTHER_CAUSES) if chances else None
    if isinstance(other, dict) and "p" in other:
        other["p"] = round(max(0.0, 1.0 - each.p - each.p_give_up - sum(chances.values())), 4)


def _kept_shares(entry: TaskEntry, each: EntryCounts) -> dict[str, float]:
    """Return probabilities of a Fail's causes in the file's proportions, because the trials recorded no
    causes.
    """
    causes = entry.fail_entries
    known = [one.p for one in causes.values() if one.p is not None]
    before = 1.0 - (entry.p_success or 0.0) - entry.p_give_up
    after = 1.0 - each.p - each.p_give_up
    if entry.p_success is None or len(known) < len(causes):
        return {cause: int(1e4 * after / (1 + len(causes))) / 1e4 for cause in causes}
    scale = after / before if before > 0.0 else 0.0
    return {cause: int(1e4 * scale * p) / 1e4 for cause, p in zip(causes, known, strict=True)}


def _with_p(row: Any, p: float) -> Any:
    """Return the row of a cause in `on_fail` with its probability added."""
    from ruamel.yaml.comments import CommentedMap

    if not isinstance(row, dict):
        row = CommentedMap({"to": row})
        row.fa.set_flow_style()
    row["p"] = p
    return row


def _rounded(seconds: float, before: float) -> float:
    """Return a time in [s], rounded for the file; the file's value if the trials took no time."""
    if math.isnan(seconds) or seconds < 0.05:
        return before
    return round(seconds, 1)


def _print_json(task: Task, found: Sequence[EntryCounts], verdict: SwitchVerdict | None) -> None:
    import orjson

    rows = [
        {
            "action": f"{entry.do} ({entry.source} to {entry.target})",
            **counts.counts._asdict(),
            "p": counts.p,
            "p_95": counts.p_95,
            "p_give_up": counts.p_give_up,
            "mean_s": counts.mean_s,
            "mean_95_s": counts.mean_95_s,
            "causes": counts.causes,
            "by_cause": {name: share._asdict() for name, share in counts.by_cause.items()},
            "by_result": [share._asdict() for share in counts.by_result],
        }
        for entry, counts in zip(task.file.actions, found, strict=True)
    ]
    switch = None if verdict is None else {**verdict._asdict(), "is_sure": verdict.is_sure}
    print(orjson.dumps({"actions": rows, "switch": switch}).decode())
