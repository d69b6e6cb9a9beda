"""Values of the rule and of the best policy on random networks, against independent solvers:
`python -m benchmarks.deciding.values`.

Also: what the policy that is followed costs over the best, and whether it ever costs more than the rule.
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

from handcart.networks.analysis.forecast import Forecaster
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.step_maker import State
from handcart.networks.deciding.best_policy import BestPolicy
from handcart.networks.deciding.run_figures import best_figures, rule_figures

from .plain_solver import best_cost, plain_network, rule_ends
from .random_networks import NETWORK_FAMILIES, drawn

PERSON_S = 600.0
VALUE_TOLERANCE = 1e-3


class Row(NamedTuple):
    """Figures of one network."""

    rule_off: float
    """Distance of the rule's P(goal), and width of its interval, from the independent value; the larger."""
    best_off: float
    """Error of the least cost, relative to it."""
    over_best: float
    """Cost of the policy that is followed over the independent lower bound, relative to it."""
    over_rule: float
    """Cost of the policy over that of the rule, in [s]."""
    cpu_s: float
    """CPU time of both values."""
    is_known: bool
    """True if the independent solvers reached the tolerance."""


def measured(family: str, seed: int, steps: float, limit_s: float) -> Row:
    """Compute both values of one network, and solve it independently."""
    task = drawn(family, seed)
    begin = time.process_time()
    best = BestPolicy(task.network, task.chances, "expected_cost", PERSON_S, Effort(steps))
    found = best.decision(State(task.network.start, ()))
    forecaster = Forecaster(task.network, task.chances, Effort(steps))
    rule = rule_figures(best.process, forecaster)
    price = best_figures(best.process, best.policy(), "best").price_s[1]
    price = min(price, rule.price_s[1]) if best.is_rule_better(forecaster) else price
    cpu = time.process_time() - begin
    plain = plain_network(task)
    least = best_cost(plain, PERSON_S, 0.1 * VALUE_TOLERANCE, limit_s)
    ends = rule_ends(plain, 0.01 * VALUE_TOLERANCE, limit_s)
    rule_off = max(abs(rule.goal[0] - ends.goal.low), rule.goal[1] - rule.goal[0])
    best_off = max(0.0, found.low - least.high, least.low - found.cost, found.cost - found.low) / least.high
    is_known = (
        least.high - least.low < VALUE_TOLERANCE * least.high
        and ends.goal.high - ends.goal.low < VALUE_TOLERANCE
    )
    over_best = max(0.0, price - least.low) / least.low
    return Row(rule_off, best_off, over_best, price - rule.price_s[1], cpu, is_known)


def main() -> None:
    """Print a line for each network and the totals."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.values", description=__doc__)
    words.add_argument("--networks", type=int, default=100, help="of each of the three families")
    words.add_argument("--first", type=int, default=0, help="first seed")
    words.add_argument("--steps", type=float, default=1.2e6, help="budget of each value")
    words.add_argument("--limit-s", type=float, default=20.0, help="CPU time of each independent solution")
    given = words.parse_args()
    rows = []
    for seed in range(given.first, given.first + given.networks):
        for family in NETWORK_FAMILIES:
            row = measured(family, seed, given.steps, given.limit_s)
            rows.append(row)
            off = f"rule off by {row.rule_off:.1e}, best by {row.best_off:.1e}"
            unsolved = "" if row.is_known else ", not solved independently"
            print(f"{family} {seed}: {off}, {row.cpu_s:.1f} s{unsolved}", flush=True)
    _print_totals(rows)


def _print_totals(rows: list[Row]) -> None:
    known = [row for row in rows if row.is_known]
    within = sum(max(row.rule_off, row.best_off) <= VALUE_TOLERANCE for row in known)
    print(
        f"{len(rows)} networks, {len(known)} solved independently; "
        f"{within} of these within {VALUE_TOLERANCE:g}"
    )
    cpu = [row.cpu_s for row in rows]
    print(f"CPU: mean {sum(cpu) / len(cpu):.2f} s, most {max(cpu):.1f} s")
    over = [row.over_best for row in known]
    print(f"cost over the best: mean {sum(over) / len(over):.4%}, most {max(over):.4%}")
    above = sum(row.over_rule > 1e-6 * PERSON_S for row in rows)
    less = -sum(row.over_rule for row in rows) / len(rows)
    print(f"above the rule: {above}; below it by {less:.1f} s in the mean")


if __name__ == "__main__":
    main()
