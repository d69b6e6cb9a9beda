"""The operator in command of a run: `handcart pause`, `continue`, `stop`, `permit` and so on."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

Run = Annotated[Path, typer.Argument(help="the run's folder")]
LatestRun = Annotated[Path | None, typer.Argument(help="the run's folder (default: runs/latest)")]
"""Option for commands that move nothing; a command that moves a robot needs the run's name."""
Json = Annotated[bool, typer.Option("--json", help="one JSON object on stdout")]
Number = Annotated[
    int | None,
    typer.Option("--number", help="number of the action, as `handcart status` shows it"),
]
Off = Annotated[bool, typer.Option("--off", help="end it")]
STOP_TIMEOUT_S = 10.0  # in which a run has to end after a stop


def pause(run: LatestRun = None, as_json: Json = False, number: Number = None) -> None:
    """Stop the robot of a run where it is; it holds still until `handcart continue`."""
    _say("pause", _or_latest(run), as_json, **_meant(number))


def go_on(run: Run, as_json: Json = False, number: Number = None) -> None:
    """Continue a run after a pause.

    If the robot was moved by hand during the pause, the changes of the running action are undone first.
    """
    _say("continue", run, as_json, **_meant(number))


def stop(run: LatestRun = None, as_json: Json = False) -> None:
    """Stop the robot where it is, end the run, and wait until it has ended; the robot holds still."""
    from handcart.networks.operator.asking import tell_to_stop

    run = _or_latest(run)
    tell_to_stop(run)
    _wait_for_end(run)
    _tell_end(run, as_json)


def cancel(run: Run, as_json: Json = False, number: Number = None) -> None:
    """Move the robot to undo what the running action has changed, and then end the run.

    If `number` is given, only the action with this number is cancelled, and no later one.
    """
    _say("cancel", run, as_json, **_meant(number))


def restore(run: Run, as_json: Json = False, number: Number = None) -> None:
    """Move the robot to undo what the running action has changed; the action ends in Fail, and the run goes
    on.
    """
    _say("restore", run, as_json, **_meant(number))


def permit(run: Run, as_json: Json = False, action: int | None = None) -> None:
    """Permit the action that waits for the operator; if `action` is given, only the action with this
    number.
    """
    _say("permit", run, as_json, **_chosen(action))


def refuse(run: Run, as_json: Json = False, action: int | None = None) -> None:
    """Refuse the action that waits for the operator, so that it ends in Fail."""
    _say("refuse", run, as_json, **_chosen(action))


def step(run: Run, as_json: Json = False, off: Off = False) -> None:
    """Let a run wait for the operator before every action from now on, or no longer with `--off`.

    The effect is that of `handcart run --step`.
    """
    _say("step", run, as_json, on=not off)


def break_at(
    run: Run,
    situation: Annotated[str, typer.Argument(help="of the task")],
    as_json: Json = False,
    off: Off = False,
) -> None:
    """Let a run wait for the operator before each action that starts from a situation, or no longer with
    `--off`.
    """
    _say("break", run, as_json, at=situation, on=not off)


def status(run: LatestRun = None, as_json: Json = False) -> None:
    """Print the activity and the situation of a run, the running action, and a question that waits for an
    answer.
    """
    _say("status", _or_latest(run), as_json)


def _or_latest(run: Path | None) -> Path:
    from handcart.networks.run_files.run_names import latest_run

    return run or latest_run(Path("runs"))


def _chosen(action: int | None) -> dict[str, int]:
    return {} if action is None else {"action": action}


def _meant(number: int | None) -> dict[str, int]:
    return {} if number is None else {"number": number}


def _say(word: str, run: Path, as_json: bool, **more: object) -> None:
    import orjson

    from handcart.networks.operator.asking import ask

    reply = ask(run, {"do": word, **more})
    if as_json:
        print(orjson.dumps(reply).decode())
    elif reply["ok"]:
        if word != "status":
            print(_echo(word, reply, more))
        waits = reply["asks"] and f"; asks for permission: {reply['asks']['index']}. {reply['asks']['do']}"
        acting = "" if reply.get("acting") is None else f" (action {reply['acting']})"
        at = f"in {reply['situation']} at {reply['sim_time_s']:.1f} s"
        print(f"{reply['state']}{acting} {at}{waits or ''}")
    else:
        print(reply["error"], file=sys.stderr)
    if not reply["ok"]:
        sys.exit(2)


def _echo(word: str, reply: Mapping[str, Any], more: Mapping[str, object]) -> str:
    """Return the effect of a command, in words."""
    off = more.get("on") is False
    match word:
        case "permit" | "refuse":
            return {"permit": "permitted", "refuse": "refused: that counts as its Fail"}[word]
        case "step":
            return (
                "it no longer asks before every action" if off else "it asks before every action from now on"
            )
        case "break":
            asks = f"before actions from {', '.join(reply['breaks']) or 'any situation'}"
            return f"it asks {asks}" if reply["breaks"] else f"it stops asking {asks}"
        case _:
            return {
                "pause": "pause requested",
                "continue": "continuation requested",
                "cancel": "cancellation requested",
                "restore": "restoring requested",
            }[word]


def _wait_for_end(run: Path) -> None:
    import time

    from handcart.networks.operator.asking import goes_on

    end = time.monotonic() + STOP_TIMEOUT_S
    while goes_on(run):
        if time.monotonic() > end:
            print(f"the run in {run} was asked to stop, and is not over yet", file=sys.stderr)
            sys.exit(5)
        time.sleep(0.02)


def _tell_end(run: Path, as_json: bool) -> None:
    import orjson

    from handcart.networks.journal.journal_record import read_journal

    last = read_journal(run / "journal.jsonl").records[-1]
    end = {key: last.get(key) for key in ("outcome", "situation", "reason")} | {"sim_time_s": last["t"]}
    if as_json:
        print(orjson.dumps({"ok": True, "state": "ended", **end}).decode())
    else:
        print(f"{end['outcome']} in {end['situation']} at {last['t']:.1f} s: {end['reason']}")
