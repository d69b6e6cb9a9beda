"""Figures on the runs of a policy: probability of the goal, times and price."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.networks.analysis.forecast import Forecast, Forecaster
from handcart.networks.chains.chain_rows import ChainEnd
from handcart.networks.chains.chain_times import Quantile, time_quantile
from handcart.networks.chains.policy import Policy
from handcart.networks.chains.policy_chain import Chain, policy_chain

from .process import Process

NO_QUANTILE = Quantile(math.nan, math.nan)
STOP_ENDS = (ChainEnd.NO_WAY, ChainEnd.GIVE_UP)
CALL_ENDS = (*STOP_ENDS, ChainEnd.UNKNOWN)
"""Ends that cost a person's time if a person is called in states that were not looked at."""


class PolicyFigures(NamedTuple):
    """Expected results of runs of a policy (probability of the goal, time and price), each with a lower and
    an upper bound.

    Both bounds are equal if all states that runs can reach were examined.
    """

    name: str
    goal: tuple[float, float]
    """Probability that the goal is reached with nothing left undone."""
    mean_s: tuple[float, float]
    """Expected time of a run, in [s]."""
    time_95_s: Quantile
    """Time within which 95 % of the runs end, in [s]."""
    price_s: tuple[float, float]
    """Expected time with the price of ends short of the goal, in [s]."""


class _Part(NamedTuple):
    """A part of the runs, and the probability that a run comes to it."""

    chain: Chain
    comes: float
    names: Sequence[str]
    """Situations of the part, by their numbers in it."""


def rule_figures(process: Process, forecaster: Forecaster) -> PolicyFigures:
    """Return the expected results of runs that follow the rule, which takes the cheapest route.

    Args:
        process: the network with the costs of its actions and of its ends.
        forecaster: forecaster of the same network and outcome probabilities.
    """
    forecast = forecaster.forecast()
    price = rule_price(process, forecaster, forecast)
    chains = [chain for _, chain in forecaster.chains()]
    actions = sum(forecaster.starts())
    quantile = time_quantile([chain.rows for chain in chains], actions)
    goal, mean = (forecast.goal, forecast.goal_high), (forecast.cost_s, forecast.cost_high_s)
    return PolicyFigures("rule", goal, mean, quantile, price)


def rule_price(process: Process, forecaster: Forecaster, forecast: Forecast) -> tuple[float, float]:
    """Return a lower and an upper bound of the expected price of a run that follows the rule, in [s].

    The rule always starts the first action of the cheapest plan to the goal. The price is the time of the
    run, plus the price of a person's help (`person_s` of the task) if it ends short of the goal.

    Args:
        process: the network with its prices.
        forecaster: forecaster of the same network and outcome probabilities.
        forecast: the result of this forecaster.
    """
    low = sum(_price(process, part) for part in _parts(forecaster))
    if not forecast.unknown:
        return low, low
    start = process.stop_price(process.network.start)
    return low, low + forecast.cost_high_s - forecast.cost_s + forecast.unknown * start


def best_figures(process: Process, policy: Policy, name: str, walks: bool = True) -> PolicyFigures:
    """Return the expected results of runs that follow a policy; in a state for which it has no decision, a
    person is called.

    Args:
        process: the network with the costs of its actions and of its ends.
        policy: the decisions.
        name: name of the policy.
        walks: whether to estimate, from random walks, the time within which 95 % of the runs end.
    """
    chain = policy_chain(policy, process.chances)
    ends = chain.ends
    mean = ends.total().first
    price = _price(process, _Part(chain, 1.0, tuple(process.network.situations)), CALL_ENDS)
    quantile = NO_QUANTILE
    if walks:
        quantile = time_quantile([chain.rows], sum(chain.starts), calls=True)
    return PolicyFigures(name, (ends.goal.p, ends.goal.p), (mean, mean), quantile, (price, price))


def _parts(forecaster: Forecaster) -> Iterator[_Part]:
    comes = 1.0
    for stage, chain in forecaster.chains():
        yield _Part(chain, comes, tuple(stage.network.situations))
        comes *= chain.ends.goal.p + chain.ends.skipped.p


def _price(process: Process, part: _Part, stopping: Collection[ChainEnd] = STOP_ENDS) -> float:
    """Return the price of one part of the runs, in [s].

    Args:
        process: the prices.
        part: the part.
        stopping: ends that cost a person's time.
    """
    stops = np.array([process.stop_price(name) for name in part.names])
    ended = part.chain.ended[:, list(stopping)].sum(axis=1)
    price = part.chain.ends.total().first + process.person_s * part.chain.skips + float(ended @ stops)
    return part.comes * price
