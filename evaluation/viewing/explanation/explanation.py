"""Explanation of a past run from its folder alone, without a simulator and without a robot."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handcart.files.errors import HandcartError, InputError
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.past_runs.hindsight import Choice, OpenRoute, Option, choice_of
from handcart.networks.past_runs.past_run import PastAction, PastRun
from handcart.networks.run_files.run_folder import JOURNAL_FILE
from handcart.networks.runs.evidence_files import EVIDENCE_FOLDER
from handcart.networks.runs.flight_recorder import END_STEM, READINGS_SUFFIX
from handcart.primitives.outcomes.residual import Residuals, read_residuals

FRAMES_SUFFIX = "_frames.log"


class NoSuchAction(InputError):
    """Error for an action's number that a run does not have."""

    def __init__(self, run: PastRun, number: int) -> None:
        last = len(run.actions)
        allowed = f"1 to {last}" if last else "none: no action was started"
        super().__init__(f"{run.folder} has no action {number}; allowed: {allowed}")


@dataclass(frozen=True)
class Explanation:
    """Evidence (choice, causes, readings and pictures) that explains an action of a run, or the run's end."""

    run: PastRun
    action: PastAction | None
    """The explained action; None: the explanation is of the run's end."""
    choice: Choice | None
    """Reasons for choosing the action; None if the journal does not contain the network."""
    relied_on: tuple[tuple[str, PastAction], ...]
    """Knowledge from earlier actions that the primitive uses: entry of the world model, and its source
    action.
    """
    residuals: Residuals
    picture: Path | None
    """The picture that decided, with the detections drawn into it."""
    points: Path | None
    """Points on the map that decided, as .npz; possibly from an earlier action whose result this one used."""
    readings: Path | None
    """Sensor readings and commands of the last seconds, as .npz."""
    drawing: Path | None = None
    """The obstacle, drawn on the map at the end of the run, as SVG."""
    frames: Path | None = None
    """The CAN frames around the action, as a candump log; or the log of another recorder."""
    frames_at: float | None = None
    """Instant in another recorder's log, in [s] of its stamps; None: `frames` is the run's own log."""

    @property
    def causes(self) -> Sequence[Mapping[str, Any]]:
        """Causes of the action's failure as the journal records them: why its motion ended, then why the
        return to the start state ended.

        It is empty without an action or recorded causes.
        """
        return tuple(self.action.result.get("cause", ())) if self.action else ()


def explain(run: PastRun, number: int | None = None) -> Explanation:
    """Explain one action of a past run.

    Args:
        run: the past run.
        number: number of the action, from 1; None: the last action that ended in Fail or GiveUp, or, if every
            action succeeded, the run's end.

    Raises:
        NoSuchAction: the run has no action with this number.
        JournalError: the journal's content is inconsistent.
    """
    with relying_on_the_journal(run):
        return _explained(run, number)


@contextmanager
def relying_on_the_journal(run: PastRun) -> Iterator[None]:
    """Convert errors in a context that are caused by inconsistent content of a journal to `JournalError`.

    Such content passes the checks on reading if, for example, somebody forged a journal with correct
    checksums.
    """
    try:
        yield
    except HandcartError:
        raise
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        words = f"what it says makes no sense: {type(error).__name__}: {error}"
        raise JournalError(run.folder / JOURNAL_FILE, words) from None


def _explained(run: PastRun, number: int | None) -> Explanation:
    action = run.last_fail if number is None else _numbered(run, number)
    if action is None:
        readings, frames = (
            _kept(run, f"{END_STEM}{READINGS_SUFFIX}"),
            _kept(run, f"{END_STEM}{FRAMES_SUFFIX}"),
        )
        return Explanation(run, None, None, (), Residuals(), None, None, readings, None, frames)
    relied_on = tuple(_relied_on(run, action))
    points = [_kept(run, f"{_stem(item)}.npz") for item in (action, *(who for _, who in relied_on[::-1]))]
    return Explanation(
        run,
        action,
        choice_of(run, action),
        relied_on,
        read_residuals(action.result.get("residuals", {}), action.result.get("tolerance", {})),
        _picture(run, action),
        next((path for path in points if path is not None), None),
        _kept(run, f"{_stem(action)}{READINGS_SUFFIX}") or _at_the_end(run, action, READINGS_SUFFIX),
        _kept(run, f"{_stem(action)}.svg"),
        _kept(run, f"{_stem(action)}{FRAMES_SUFFIX}") or _at_the_end(run, action, FRAMES_SUFFIX),
    )


def _numbered(run: PastRun, number: int) -> PastAction:
    found = next((action for action in run.actions if action.number == number), None)
    if found is None:
        raise NoSuchAction(run, number)
    return found


def _relied_on(run: PastRun, action: PastAction) -> list[tuple[str, PastAction]]:
    """Return the used entries of the world model, each with the last earlier action that learned it."""
    uses = run.network.uses[action.index] if run.network else ()
    learned: dict[str, PastAction] = {}
    for item in run.actions[: run.actions.index(action)]:
        for name, value in item.result.get("learned", {}).items():
            if value is None:
                learned.pop(name, None)
            else:
                learned[name] = item
    return [(name, learned[name]) for name in uses if name in learned]


def _stem(action: PastAction) -> str:
    ended = "" if action.outcome in ("Success", "") else f"_{action.outcome}"
    return f"{action.number:03d}_{action.do}{ended}"


def _picture(run: PastRun, action: PastAction) -> Path | None:
    """Return the picture that the primitive named, otherwise the one written last."""
    named = action.result.get("picture")
    if named:
        return _kept(run, f"{_stem(action)}_{named}.png")
    pictures = [
        path for path in (run.folder / EVIDENCE_FOLDER).glob(f"{action.number:03d}_*.png") if path.is_file()
    ]
    return max(pictures, key=lambda path: (path.stat().st_mtime_ns, path.name), default=None)


def _at_the_end(run: PastRun, action: PastAction, suffix: str) -> Path | None:
    """Return a file of the run's end if the action was interrupted there, otherwise None."""
    return _kept(run, f"{END_STEM}{suffix}") if action is run.actions[-1] and not action.outcome else None


def _kept(run: PastRun, name: str) -> Path | None:
    path = run.folder / EVIDENCE_FOLDER / name
    # A forged journal may name any path.
    return path if path.name == name and path.is_file() else None


def as_json(explanation: Explanation, chart: Path | None) -> dict[str, Any]:
    """Return an explanation as JSON values; raise `JournalError` if the journal's content is inconsistent."""
    with relying_on_the_journal(explanation.run):
        return _json(explanation, chart)


def _json(explanation: Explanation, chart: Path | None) -> dict[str, Any]:
    run, header = explanation.run, explanation.run.header
    end = run.end
    return {
        "run_dir": str(run.folder),
        **{key: header.get(key) for key in ("task", "robot", "backend", "seed", "handcart")},
        "outcome": end["outcome"] if end else None,
        "situation": end["situation"] if end else None,
        "reason": end["reason"] if end else None,
        "torn_at": run.torn_at,
        "actions": [_action_json(action) for action in run.actions],
        "action": explanation.action.number if explanation.action else None,
        "choice": _choice_json(explanation.choice) if explanation.choice else None,
        "relied_on": {name: who.number for name, who in explanation.relied_on},
        "cause": list(explanation.causes),
        "residuals": [
            {"name": r.label, "size": _finite(r.value), "limit": r.limit, "within": r.is_within}
            for r in explanation.residuals.all
        ],
        "picture": explanation.picture and str(explanation.picture),
        "points": explanation.points and str(explanation.points),
        "readings": explanation.readings and str(explanation.readings),
        "frames": explanation.frames and str(explanation.frames),
        "chart": chart and str(chart),
    }


def _action_json(action: PastAction) -> dict[str, Any]:
    return {
        "n": action.number,
        "do": action.do,
        "from": action.source,
        "to": action.target,
        "with": action.parameters,
        "start_s": action.start,
        "broken_off_s": action.broken_off,
        "end_s": action.end,
        "outcome": action.outcome or None,
        "reason": action.reason,
    }


def _choice_json(choice: Choice) -> dict[str, Any]:
    return {
        "way": _way_json(choice.way),
        "policy": choice.policy,
        "judged": choice.judged and choice.judged.fields(),
        "options": [
            {**_option_json(option), "chosen_below_s": option.threshold_s(choice.way)}
            for option in choice.options
        ],
        "next_best": choice.next_best and _way_json(choice.next_best),
        "after_fail": next((_way_json(fail.way) for fail in choice.after_fails if not fail.cause), None),
        "after_fail_by_cause": {fail.cause: _way_json(fail.way) for fail in choice.after_fails if fail.cause},
    }


def _option_json(option: Option) -> dict[str, Any]:
    return {
        "index": option.action.index,
        "do": option.action.do,
        "to": option.action.target,
        "weight_s": option.weight,
        "fails": option.fails,
        "way": option.way and _way_json(option.way),
        "out": option.out,
        "p_goal": option.value and option.value.goal,
        "mean_s": option.value and option.value.mean_s,
        "believed": option.believed,
    }


def _way_json(way: OpenRoute) -> dict[str, Any]:
    return {"actions": [action.index for action in way.actions], "cost_s": way.cost}


def _finite(size: float) -> float | None:
    return size if math.isfinite(size) else None
