"""Report of `handcart check` on a task's network."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from handcart.files.stages import begin_stage

from .belief_table import belief_facts
from .policy_table import comparison_lines

if TYPE_CHECKING:
    from handcart.networks.analysis.figures import Figures, Influence
    from handcart.networks.analysis.forecast import Forecast, Forecaster
    from handcart.networks.analysis.worst_cases import WorstCases
    from handcart.networks.deciding.best_policy import PolicyName
    from handcart.networks.deciding.comparison import PolicyComparison
    from handcart.networks.task.task_file import Task

Watch = Callable[[float], None]
"""Function that is called from time to time with the finished share, 0 to 1."""
MAX_PRINTED_LINES = 30
"""Maximum number of printed lines of one kind."""
SHORT_HEADING = (
    "where a run may end short of the goal, with the fewest Fails (another way or more attempts would help):"
)


def task_facts(task: Task, watch: Watch = lambda share: None) -> dict[str, Any]:
    """Return the facts of a task's network.

    They are the size of the network, actions that can never start (`errors`), parts that are probably
    mistakes (`warnings`), situations in which runs may end before the goal (`short`), and the probabilities
    of all ends (`figures`, and as text in `lines`).

    Args:
        task: the task.
        watch: called from time to time with the finished share, 0 to 1.
    """
    from handcart.networks.analysis.hand_findings import hand_findings
    from handcart.networks.analysis.task_findings import short_findings, task_findings, unused_findings
    from handcart.networks.analysis.worst_cases import worst_cases
    from handcart.networks.chains.effort import Effort
    from handcart.networks.chains.policy import budget_of

    begin_stage("how runs end")
    network = task.network
    facts: dict[str, Any] = {
        "title": task.file.title,
        "situations": len(network.situations),
        "actions": len(network.actions),
        **network.aims.words(),
    }
    warnings = task_findings(task)
    cases = worst_cases(network, Effort(budget_of(network), lambda share: watch(share / 3.0)))
    if cases.too_large:
        facts["worst cases"] = _looked_at(cases)
    forecaster = _forecaster(task, watch)
    figures, lines = _figures(task, watch, forecaster)
    compared = _compared(task, forecaster)
    warnings += unused_findings(task, cases, compared.used if compared else None)
    if compared is not None:
        figures["policies"] = compared.for_programs()
        lines += comparison_lines(compared, network.person_s)
        fields, more = belief_facts(network)
        figures, lines = {**figures, **fields}, [*lines, *more]
    short = list(map(str, short_findings(task, cases)))
    return {
        **facts,
        "longest run": _longest(cases),
        "errors": hand_findings(task),
        "warnings": list(map(str, warnings)),
        "short": short,
        **figures,
        "lines": [*([SHORT_HEADING] if short else []), *_first([f"  {item}" for item in short]), *lines],
    }


def _forecaster(task: Task, watch: Watch) -> Forecaster | None:
    """Return the forecaster of how runs end; None if a probability is missing."""
    from handcart.networks.analysis.figures import missing_chances, network_chances
    from handcart.networks.analysis.forecast import Forecaster
    from handcart.networks.chains.effort import Effort
    from handcart.networks.chains.policy import budget_of

    if missing_chances(task):
        return None
    effort = Effort(budget_of(task.network), lambda share: watch((1.0 + share) / 3.0))
    return Forecaster(task.network, network_chances(task), effort)


def _compared(task: Task, forecaster: Forecaster | None) -> PolicyComparison | None:
    """Return the rule and the best policy side by side; None if a probability is missing."""
    from handcart.networks.analysis.figures import network_chances
    from handcart.networks.deciding.comparison import comparison

    if forecaster is None:
        return None
    policy = task.network.policy
    name: PolicyName = "goal_probability" if policy == "goal_probability" else "expected_cost"
    return comparison(task.network, network_chances(task), name, forecaster)


def _longest(cases: WorstCases) -> str:
    low, high = cases.longest_low, cases.longest
    return f"at most {high} actions" if low == high else f"between {low} and {high} actions"


def _looked_at(cases: WorstCases) -> str:
    """Return which parts of the network were not looked at completely, in words."""
    parts = sorted({f"{item.part} ({item.count} states looked at)" for item in cases.too_large})
    return f"not all states were looked at {'; '.join(parts)}; fewer attempts make a part smaller"


def _first(lines: list[str]) -> list[str]:
    """Return at most `MAX_PRINTED_LINES` lines, and one that counts the omitted ones."""
    left = len(lines) - MAX_PRINTED_LINES
    return [*lines[:MAX_PRINTED_LINES], f"  and {left} more (`--json` has them all)"] if left > 0 else lines


def _figures(task: Task, watch: Watch, forecaster: Forecaster | None) -> tuple[dict[str, Any], list[str]]:
    """Return how runs end, if the file gives all probabilities, as fields and as lines of text."""
    from handcart.networks.analysis.figures import figures, missing_chances
    from handcart.networks.chains.effort import Effort
    from handcart.networks.chains.policy import DEFAULT_MAX_STEPS

    missing = missing_chances(task)
    if len(missing) == len(task.file.actions):
        return {}, []
    if missing:
        places = [task.document.position(("actions", number))[0] for number in missing]
        which = ", ".join(
            f"{task.file.actions[number].do} (line {line})"
            for number, line in zip(missing, places, strict=True)
        )
        return {"how runs end": f"not known: `p` is missing in {which}"}, []
    more = Effort(DEFAULT_MAX_STEPS, lambda share: watch((2.0 + share) / 3.0))
    found = figures(task, more=more, forecaster=forecaster)
    return {"figures": found.for_programs()}, _lines(found)


def _lines(found: Figures) -> list[str]:
    from handcart.networks.analysis.figures import FORECAST_ASSUMPTION

    now = found.forecast
    undone = f", elements left undone {_ranged(now.left_undone, now)}" if now.left_undone else ""
    short = f"no way left {_ranged(now.no_way, now)}, a person is needed {_ranged(now.give_up, now)}"
    ends = f"P(goal) {_ranged(now.goal, now)}{undone}, {short}"
    head = f"  {'action':<48}{'line':>5}{'p':>7}{'starts':>9}{'slope':>9}"
    return [
        f"how runs end, if {FORECAST_ASSUMPTION}:",
        f"  {ends}",
        f"  {_cost(now)}",
        "influence on P(goal) (slope by p), and change of P(goal) and cost by more attempts:",
        f"{head}{'one more attempt':>22}{'an alternative':>22}",
        *_first([_row(influence, now) for influence in found.influences]),
    ]


def _row(each: Influence, now: Forecast) -> str:
    figures = f"{each.line:>5}{each.chance.success:>7.3g}{each.starts:>9.3f}{each.slope:>9.4f}"
    changes = "".join(f"{_change(then, each, now):>22}" for then in (each.one_more, each.alternative))
    return f"  {each.words:<48}{figures}{changes}"


def _change(then: Forecast | None, each: Influence, now: Forecast) -> str:
    if then is None:
        low, high = each.bounds
        return f"[{low:+.5f}, {high:+.5f}]"
    return f"{then.goal - now.goal:+.5f} {then.cost_s - now.cost_s:+.1f} s"


def _ranged(p: float, now: Forecast) -> str:
    """Return a probability, or its interval if states were not looked at."""
    return f"{p:.5f}" if now.unknown < 5e-6 else f"[{p:.5f}, {min(1.0, p + now.unknown):.5f}]"


def _cost(now: Forecast) -> str:
    if now.unknown < 5e-6:
        return f"expected cost {now.cost_s:.1f} s, standard deviation {now.cost_sigma_s:.1f} s"
    return f"expected cost [{now.cost_s:.1f}, {now.cost_high_s:.3g}] s"
