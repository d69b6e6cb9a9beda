"""`handcart compare`: two runs side by side, and where they part."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.networks.past_runs.past_run import PastAction
    from handcart.networks.past_runs.run_comparison import ComparedAction, RunComparison

SHOWN_CHARACTERS = 60  # of a value in the setting


def compare(
    one: Annotated[Path, typer.Argument(help="a run's folder, or an archive of it (.zip, .tar.gz)")],
    other: Annotated[Path, typer.Argument(help="another run's")],
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Compare two runs action by action, and print the first difference, outcomes, residuals and times."""
    import orjson

    from handcart.files.printable import printable
    from handcart.networks.past_runs.past_run import read_run
    from handcart.networks.past_runs.run_comparison import compare_runs
    from handcart.networks.run_files.run_archive import opened_run

    with ExitStack() as stack:
        folders = [stack.enter_context(opened_run(item)) for item in (one, other)]
        found = compare_runs(*map(read_run, folders))
    if as_json:
        print(orjson.dumps(_facts(found), option=orjson.OPT_INDENT_2).decode())
        return
    for line in _lines(found, (one, other)):
        print(printable(line))


def _lines(found: RunComparison, names: tuple[Path, Path]) -> Iterator[str]:
    from handcart.networks.past_runs.run_comparison import record_words

    for letter, name, run in zip("AB", names, (found.one, found.other), strict=True):
        yield f"{letter}: {name}: {run.header.get('task')}, seed {run.header.get('seed')}, {_ended(run.end)}"
    for key, (mine, theirs) in found.headers.items():
        yield f"the setting differs in {key}: A {_short(mine)}, B {_short(theirs)}"
    yield ""
    yield from _table(found)
    yield ""
    if found.first_record is None:
        yield "the journals are equal but for the wall clock"
        return
    if found.first is None:
        yield "same actions and outcomes; times or details differ"
    else:
        yield f"first difference, in {found.first.differs}: {_parting(found.first)}"
    yield f"first different record: {record_words(found.first_record)}"
    yield from _residual_lines(found)


def _ended(end: Any) -> str:
    return "no end" if end is None else f"{end['outcome']} in {end['situation']} at {end['t']:.1f} s"


def _short(value: Any) -> str:
    words = str(value)
    return words if len(words) <= SHOWN_CHARACTERS else f"{words[: SHOWN_CHARACTERS - 3]}..."


def _table(found: RunComparison) -> Iterator[str]:
    head = ("", "action", "A", "B", "A s", "B s", "differs in")
    rows = [head, *(_row(action, action is found.first) for action in found.actions)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip()


def _row(each: ComparedAction, is_first: bool) -> tuple[str, ...]:
    mine, theirs = each.seconds
    action = each.action
    return (
        ">" if is_first else "",
        f"{action.do} ({action.source} to {action.target})",
        _outcome(each.one),
        _outcome(each.other),
        "" if mine is None else f"{mine:.2f}",
        "" if theirs is None else f"{theirs:.2f}",
        each.differs,
    )


def _outcome(action: PastAction | None) -> str:
    if action is None:
        return "-"
    cause = f" {action.cause}" if action.cause else ""
    return f"{action.number} {action.outcome or 'no end'}{cause}"


def _parting(each: ComparedAction) -> str:
    sides = zip("AB", (each.one, each.other), strict=True)
    words = [
        f"{letter} {_outcome(side)}{f': {side.reason}' if side and side.reason else ''}"
        for letter, side in sides
    ]
    return f"{each.action.do} ({each.action.source} to {each.action.target}): {'; '.join(words)}"


def _residual_lines(found: RunComparison) -> Iterator[str]:
    for action in found.actions:
        if action.one is None or action.other is None:
            continue
        for name, mine, theirs in action.residuals():
            sizes = " ".join(f"{letter} {_size(size)}" for letter, size in (("A", mine), ("B", theirs)))
            yield f"residual {name} of {action.action.do} (action {action.one.number} of A): {sizes}"


def _size(size: float | None) -> str:
    return "-" if size is None else f"{size:.4g}"


def _facts(found: RunComparison) -> dict[str, Any]:
    from handcart.networks.past_runs.run_comparison import record_words

    return {
        "equal": found.equal,
        "setting": {key: list(pair) for key, pair in found.headers.items()},
        "outcomes": [run.end and run.end["outcome"] for run in (found.one, found.other)],
        "first_difference": None if found.first is None else found.actions.index(found.first),
        "first_record": None if found.first_record is None else record_words(found.first_record),
        "actions": [_action_facts(action) for action in found.actions],
    }


def _action_facts(each: ComparedAction) -> dict[str, Any]:
    sides = (each.one, each.other)
    return {
        "do": each.action.do,
        "from": each.action.source,
        "to": each.action.target,
        "n": [side and side.number for side in sides],
        "outcomes": [side and (side.outcome or None) for side in sides],
        "causes": [side and (side.cause or None) for side in sides],
        "reasons": [side and side.reason for side in sides],
        "seconds": list(each.seconds),
        "residuals": {name: [mine, theirs] for name, mine, theirs in each.residuals()},
        "differs": each.differs or None,
    }
