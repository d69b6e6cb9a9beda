"""Policies of probabilities that were learned from a few attempts of each action, on random networks:
`python -m benchmarks.deciding.learned`.

The policy leaves the rule only where the posterior says that it is better in 95 % of draws.
"""

from __future__ import annotations

import argparse
import random
from typing import NamedTuple

from handcart.networks.chains.chance import Chance
from handcart.networks.chains.effort import Effort
from handcart.networks.chains.policy import explored
from handcart.networks.chains.step_maker import State
from handcart.networks.deciding.best_policy import BestPolicy
from handcart.networks.deciding.posterior import OutcomeCounts, judge_switch
from handcart.networks.deciding.process import Process
from handcart.networks.deciding.run_figures import best_figures

from .random_networks import NETWORK_FAMILIES, Drawn, drawn

PERSON_S = 600.0
MAX_RULE_STEPS = 150_000.0


class Compared(NamedTuple):
    """Costs of one network by its true probabilities, in [s]."""

    rule: float
    learned: float
    best: float
    switched: bool


def compared(task: Drawn, attempts: int, seed: int) -> Compared | None:
    """Learn from some attempts of each action, decide by that, and compute the true cost.

    Returns:
        The costs; None if the rule has too many states for an exact value.
    """
    draws = random.Random(f"{seed} {attempts}")
    counts = [None if chance is None else _tried(chance, attempts, draws) for chance in task.chances]
    rule = explored(task.network, effort=Effort(MAX_RULE_STEPS))
    if not rule.is_complete:
        return None
    process = Process(task.network, task.chances, PERSON_S)
    cost = best_figures(process, rule, "rule", walks=False).price_s[0]
    exact = BestPolicy(task.network, task.chances, "expected_cost", PERSON_S)
    least = exact.decision(State(task.network.start, ())).cost
    verdict = judge_switch(task.network, counts, person_s=PERSON_S)
    if not verdict.is_sure:
        return Compared(cost, cost, least, False)
    chosen = BestPolicy(task.network, [count and count.chance for count in counts], "expected_cost", PERSON_S)
    chosen.decision(State(task.network.start, ()))
    learned = best_figures(process, chosen.policy(), "learned", walks=False).price_s[0]
    return Compared(cost, learned, least, True)


def _tried(chance: Chance, attempts: int, draws: random.Random) -> OutcomeCounts:
    ends = [draws.random() for _ in range(attempts)]
    successes = sum(end < chance.success for end in ends)
    give_ups = sum(end >= 1.0 - chance.give_up for end in ends)
    return OutcomeCounts(successes, attempts - successes - give_ups, give_ups)


def main() -> None:
    """Print a line for each number of attempts."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.learned", description=__doc__)
    words.add_argument("--networks", type=int, default=50, help="of each of the three families")
    words.add_argument("--first", type=int, default=0, help="first seed")
    words.add_argument("--most", type=int, default=9, help="situations of a network, at most")
    words.add_argument("--attempts", type=int, nargs="*", default=[3, 10, 30])
    given = words.parse_args()
    for attempts in given.attempts:
        print(f"{attempts} attempts of each action ...", flush=True)
        tasks = (
            (drawn(family, seed, given.most), seed)
            for seed in range(given.first, given.first + given.networks)
            for family in NETWORK_FAMILIES
        )
        found = [each for task, seed in tasks if (each := compared(task, attempts, seed)) is not None]
        _print_row(found)


def _print_row(found: list[Compared]) -> None:
    count = len(found)
    worse = sum(compared_.learned > compared_.rule * (1.0 + 1e-6) for compared_ in found)
    switched = sum(compared_.switched for compared_ in found)
    over_rule = sum(compared_.rule / compared_.best - 1.0 for compared_ in found) / count
    over = sum(compared_.learned / compared_.best - 1.0 for compared_ in found) / count
    costs = f"cost over the best: rule {over_rule:.1%}, learned {over:.1%}"
    share = f"{worse} ({worse / count:.1%})"
    print(f"  {count} networks: {costs}; left the rule in {switched}, worse than it in {share}", flush=True)


if __name__ == "__main__":
    main()
