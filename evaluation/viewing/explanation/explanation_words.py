"""Explanation as text for people."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from handcart.networks.graph.belief_prior import Judged
from handcart.networks.graph.planner import SKIP_WEIGHT
from handcart.networks.past_runs.hindsight import Choice, OpenRoute, Option
from handcart.networks.past_runs.past_run import PastAction, PastRun
from handcart.primitives.outcomes.residual import Residual

from .explanation import Explanation, relying_on_the_journal

CHECK_TEXTS = {
    "observe": "while looking at what it will touch",
    "motion": "in its motion",
    "watch": "by its watch, asked every period",
    "effect": "by its look at the effect, at rest at the end",
    "restore": "on the way back",
    "finish": "while withdrawing",
    "rest": "while waiting for rest",
    "push": "by looking where the base stands",
    "following": "by comparing the arm's readings with its commands",
    "time": "by the clock",
    "supervision": "from outside",
    "framework": "by the framework",
}
"""Text for each kind of check that may find a fault, by its name in the journal."""
MAX_ROUTE_ACTIONS = 6  # actions of a route that are named


def in_words(explanation: Explanation, chart: Path | None) -> str:
    """Return a text with one line for each action of the run, followed by the explanation of one action.

    Args:
        explanation: explanation of an action or of the run's end.
        chart: path of the explanation's chart; None if no chart was drawn.

    Raises:
        JournalError: the journal's content is inconsistent.
    """
    with relying_on_the_journal(explanation.run):
        return _in_words(explanation, chart)


def _in_words(explanation: Explanation, chart: Path | None) -> str:
    parts = [_head(explanation.run), _time_line(explanation.run, explanation.action)]
    if explanation.action is not None:
        parts += [
            _about(explanation.action),
            _chosen(explanation),
            _happened(explanation),
            _restored(explanation),
        ]
    parts.append(_frames(explanation))
    parts.append(_files(explanation, chart))
    return "\n\n".join(part for part in parts if part)


def _head(run: PastRun) -> str:
    header, end = run.header, run.end
    lines = [f"{run.folder}: {header['task']} (backend {header['backend']}, seed {header['seed']})"]
    if end is None:
        lines.append("no end in the journal: it was killed, or is still running")
    else:
        reason = f": {end['reason']}" if end["reason"] else ""
        lines.append(f"{end['outcome']} in situation {end['situation']}{reason}")
    return "\n".join(lines)


def _time_line(run: PastRun, chosen: PastAction | None) -> str:
    if not run.actions:
        return "No action was started."
    do = max(len(action.do) for action in run.actions)
    way = max(len(f"{action.source} to {action.target}") for action in run.actions)
    lines = [(float(item["t"]), f"      {item['t']:8.1f} s  {words}") for item, words in aim_words(run)]
    lines += [(action.start, _line(action, action is chosen, do, way)) for action in run.actions]
    return "\n".join(line for _, line in sorted(lines, key=lambda item: item[0]))


def aim_words(run: PastRun) -> Iterator[tuple[Mapping[str, Any], str]]:
    """Yield the journal's records of changes of the goal, each with a text.

    Such changes are a new round of a task that is repeated, an interrupt, and a goal that was abandoned.
    """
    interrupts = run.network.network.aims.interrupts if run.network else ()
    for record in run.records:
        if record["kind"] != "AIM":
            continue
        if record["what"] in ("round", "wait"):
            number = record.get("round", 1)
            yield record, f"round {number} may begin at {record.get('at_s', record['t']):.1f} s"
        elif record["what"] == "abandon":
            yield record, f"the goal is abandoned: {record['reason']}"
        else:
            number = record["interrupt"]
            name = interrupts[number].name if number < len(interrupts) else f"interrupt {number}"
            goal = f"first to {record['goal']}" if "goal" in record else "no route leads there"
            yield record, f"{name}: {goal}"


def _line(each: PastAction, chosen: bool, do: int, way: int) -> str:
    mark = ">" if chosen else " "
    leads = f"{each.source} to {each.target}"
    ended = each.outcome or "no end"
    reason = f": {each.reason}" if each.reason else ""
    return f"{mark}{each.number:4d}  {each.start:8.1f} s  {each.do:<{do}}  {leads:<{way}}  {ended}{reason}"


def _about(action: PastAction) -> str:
    given = ", ".join(f"{name}={value}" for name, value in action.parameters.items())
    return f"Action {action.number}: {action.do}{f' with {given}' if given else ''}"


def _chosen(explanation: Explanation) -> str:
    lines = ["Why it was chosen"]
    if explanation.choice is None:
        return "\n".join(
            [*lines, "  the journal doesn't keep the network, so what else there was isn't known"]
        )
    lines += [f"  {line}" for line in choice_words(explanation.choice)]
    known = ", ".join(f"{name} (action {who.number}, {who.do})" for name, who in explanation.relied_on)
    return "\n".join([*lines, *([f"  what it could use: {known}"] if known else [])])


def choice_words(choice: Choice) -> Iterator[str]:
    """Yield the reasons for choosing an action: its route to the goal, and the alternatives."""
    chosen, *others = choice.options
    fails = f", failed {_times(chosen.fails)} before" if chosen.fails else ""
    yield f"{_chosen_words(choice)}: {_steps(choice.way)}{_value_words(chosen)}"
    yield f"{chosen.action.do} counted {_seconds(chosen.weight)} of it{fails}"
    if choice.judged is not None:
        yield from _judged_words(choice, choice.judged)
    if not others:
        yield f"nothing else leads out of {choice.chosen.source}"
    for other in others:
        yield f"instead {other.action}: {_instead(other)}{_value_words(other)}{_change_words(other, choice)}"
    later = choice.next_best
    if later is not None and later.actions[0] is choice.chosen:
        yield f"the next best way parts from it later, {_cost(later)}: {_steps(later)}"
    if later is None:
        yield "no other way led to the goal"
    for fail in choice.after_fails:
        cause = f" by {fail.cause}" if fail.cause else ""
        rest = f"{_cost(fail.way)} from the goal: {_steps(fail.way)}"
        yield f"a Fail{cause} leads to {fail.situation}, then {rest}"


def _chosen_words(choice: Choice) -> str:
    if choice.policy == "goal_probability":
        return "largest probability of the goal"
    if choice.policy == "expected_cost":
        return f"least expected price, {_seconds(choice.way.cost)}"
    return f"cheapest way to the goal, {_cost(choice.way)}"


def _judged_words(choice: Choice, judged: Judged) -> Iterator[str]:
    """Yield the policy that the run's outcomes favour, and the probabilities that they changed, in words."""
    found = f"better than the rule in {judged.better:.1%} of draws, by {judged.saved_s:.1f} s in the mean"
    if judged.follows != "rule":
        yield f"by the run's outcomes the policy {judged.follows} is {found}: it is followed"
    elif judged.better or judged.saved_s:
        yield f"by the run's outcomes the best policy is {found}; needed to leave the rule: 95 %"
    else:
        yield "by the run's outcomes the best policy decides as the rule does"
    for option in choice.options:
        p, believed = option.action.p_success, option.believed
        if p is not None and believed is not None and abs(p - believed) >= 5e-4:
            yield f"{option.action} is believed to succeed with p {believed:.3f}, by the file {p:g}"


def _value_words(option: Option) -> str:
    """Return P(goal) and mean time of a run with an action, in words; empty without probabilities."""
    value = option.value
    return "" if value is None else f"; P(goal) {value.goal:.4f}, {value.mean_s:.1f} s in the mean"


def _change_words(option: Option, choice: Choice) -> str:
    """Return the cost below which the rule would have chosen an action, in words."""
    if choice.policy != "rule" or option.way is None or option.action.binding is None:
        return ""
    below = option.threshold_s(choice.way)
    if below is None:
        return "; chosen at no cost"
    return f"; chosen below {below:g} s instead of {option.action.cost_s:g} s"


def _instead(option: Option) -> str:
    fails = f", failed {_times(option.fails)} before" if option.fails else ""
    if option.way is None:
        return option.out
    return f"{_cost(option.way)}{fails}: {_steps(option.way)}"


def _steps(way: OpenRoute) -> str:
    names = [action.do for action in way.actions]
    return ", ".join([*names[:MAX_ROUTE_ACTIONS], *(["..."] if len(names) > MAX_ROUTE_ACTIONS else [])])


def _cost(way: OpenRoute) -> str:
    return _seconds(way.cost)


def _seconds(cost: float) -> str:
    """Return a cost as text: seconds, and the number of skipped actions."""
    skipped, rest = divmod(cost, SKIP_WEIGHT)
    undone = f" and {skipped:.0f} left undone" if skipped else ""
    return f"{rest:g} s{undone}"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _happened(explanation: Explanation) -> str:
    action = explanation.action
    assert action is not None
    if action.outcome in ("Success", ""):
        lines = ["What happened", f"  {action.start:.1f} to {action.end:.1f} s: {action.outcome or 'no end'}"]
        return "\n".join([*lines, *(f"  {line}" for line in _facts(action))])
    lines = [f"Why it ended in {action.outcome}"]
    lines += [f"  {line}" for cause in explanation.causes for line in cause_words(action, cause)]
    if not explanation.causes:
        lines.append(f"  {action.reason} (the journal keeps no more)")
    return "\n".join([*lines, *(f"  {line}" for line in _facts(action))])


def cause_words(action: PastAction, cause: Mapping[str, Any]) -> Iterator[str]:
    """Yield a cause of failure as lines of text: reason, then primitive, check, functions and measurement."""
    when = action.end if action.broken_off is None or cause.get("restoring") else action.broken_off
    kind = f" [{cause['kind']}]" if cause.get("kind") else ""
    yield f"{when:.1f} s: {cause['reason']}{kind}"
    chain = [action.do, f"found {CHECK_TEXTS.get(cause['check'], cause['check'])}"]
    if cause["calls"]:
        chain.append(" > ".join(cause["calls"]))
    if cause.get("fault"):
        chain.append(f"{cause['fault']}: a fault in the code, not in the world")
    if cause.get("measured"):
        chain.append(measured_words(cause["measured"]))
    for depth, link in enumerate(chain):
        yield f"  {'   ' * (depth - 1)}{'└─ ' if depth else ''}{link}"


def measured_words(measured: Mapping[str, Any]) -> str:
    """Return a measurement as text, for example `Arm: force that resists 8.1 N, needed: at most 7 N`."""
    head = f"{measured['sensor']}: {measured['what']}"
    value, limit = measured["value"], measured["limit"]
    unit = f" {measured['unit']}" if measured["unit"] else ""
    if value is None:
        return f"{head}: not seen{'' if limit is None else f' within {limit:.3g}{unit}'}"
    if limit is None:
        return f"{head} {value:.3g}{unit}"
    return f"{head} {value:.3g}{unit}, needed: at {'least' if value < limit else 'most'} {limit:.3g}{unit}"


def _facts(action: PastAction) -> Iterator[str]:
    """Yield the evidence that the primitive recorded."""
    found: Mapping[str, float | str] = action.result.get("evidence", {})
    if found:
        yield "it noted:"
    for name, value in found.items():
        said = f"{value:g}" if isinstance(value, float | int) else str(value).strip().replace("\n", "\n    ")
        yield f"  {name} {said}"


def _restored(explanation: Explanation) -> str:
    action = explanation.action
    assert action is not None
    if not action.fails:
        return ""
    if not explanation.residuals:
        said = "nothing had moved" if action.outcome == "Fail" else "it was not measured"
        return f"What was restored\n  nothing to compare: {said}"
    lasted = "" if action.broken_off is None else f", {action.broken_off:.1f} to {action.end:.1f} s"
    return "\n".join([f"What was restored{lasted}", *_table(explanation.residuals.all)])


def _table(residuals: Sequence[Residual]) -> Iterator[str]:
    width = max(len(residual.label) for residual in residuals)
    for residual in residuals:
        size = f"{residual.value:9.3f}" if math.isfinite(residual.value) else "     gone"
        limit = "" if residual.limit is None else f"  at most {residual.limit:g}"
        yield f"  {residual.label:<{width}}  {size}{limit}{'' if residual.is_within else '   <- beyond it'}"


def _frames(explanation: Explanation) -> str:
    """Return the CAN frames around the action as text; empty if none were recorded."""
    if explanation.frames is None:
        return ""
    from .frames_around import frames_around, in_words

    action, last = explanation.action, float(explanation.run.records[-1]["t"])
    end = action.end if action else last
    instant = end if action is None or action.broken_off is None else action.broken_off
    if explanation.frames_at is not None:
        instant = explanation.frames_at
    try:
        around = frames_around(explanation.frames, explanation.run.folder, instant)
    except (OSError, ValueError) as error:
        if explanation.frames_at is not None:
            raise
        return f"Frames on the CAN bus\n  they can't be read: {error}"
    where = f"around {instant:.3f} s" if math.isfinite(instant) else f"at the end of {explanation.frames}"
    head = f"Frames on the CAN bus {where}, without what was said before"
    return "\n".join([head, *(f"  {line}" for line in in_words(around))])


def _files(explanation: Explanation, chart: Path | None) -> str:
    named = {
        "what was seen": explanation.picture,
        "points on the map": explanation.points,
        "last readings and commands": explanation.readings,
        "CAN frames": explanation.frames,
        "drawn": chart,
    }
    return "\n".join(f"{what}: {path}" for what, path in named.items() if path is not None)
