"""Beliefs in the probabilities of a task's actions, which outcomes change during a run."""

from __future__ import annotations

import numpy as np

from handcart.networks.chains.chance import Chance
from handcart.networks.graph.belief_prior import BeliefPrior
from handcart.networks.graph.network import Action, ActionNetwork
from handcart.robotics.numerics.arrays import FloatArray

DRAW_COUNT = 200


class Beliefs:
    """Beliefs about the outcome probabilities of each action of a task file, as weights of the outcomes.

    The weights of Success, Fail and GiveUp are the parameters of a Dirichlet distribution. At first they are
    the probabilities in the file times the prior's number of attempts. Each Success or Fail adds 1 to its
    weight; GiveUp keeps its weight, because it ends a run. If a `repeat` copies an action for each element of
    a list, all copies share weights.
    """

    def __init__(self, network: ActionNetwork, prior: BeliefPrior) -> None:
        """Begin with the prior.

        Args:
            network: the network; all its actions have probabilities.
            prior: weight of its probabilities, and the entry of each action.
        """
        self._network, self._entries = network, prior.entries
        self._prior: dict[int, tuple[float, float, float]] = {}
        for action in network.actions:
            if action.binding is not None:
                p = 1.0 if action.p_success is None else action.p_success
                fail = max(0.0, 1.0 - p - action.p_give_up)
                weights = prior.attempts * p, prior.attempts * fail, prior.attempts * action.p_give_up
                self._prior.setdefault(self._entries[action.index], weights)
        self._seen: dict[int, tuple[int, int]] = {}

    def succeeded(self, action: Action) -> bool:
        """Count a Success of an action; return whether a belief changed.

        The beliefs about actions whose attempts the Success renews go back to the prior.
        """
        for counter in self._network.renewed_by.get(action.index, ()):
            for item in self._network.shared[counter]:
                self._seen.pop(self._entries[item.index], None)
        return self._count(action, 1, 0)

    def failed(self, action: Action) -> bool:
        """Count a Fail of an action, and return whether a belief about its outcome probabilities changed.

        It is False for an action that only skips an element of a list over which the task repeats actions.
        """
        return self._count(action, 0, 1)

    def _count(self, action: Action, success: int, fail: int) -> bool:
        entry = self._entries[action.index]
        if entry < 0:
            return False
        successes, fails = self._seen.get(entry, (0, 0))
        self._seen[entry] = successes + success, fails + fail
        return True

    def weights(self, entry: int) -> tuple[float, float, float]:
        """Return the present weights of an action's Success, Fail and GiveUp, by its number in the file.

        The weights are the parameters of the Dirichlet distribution of the outcome probabilities.
        """
        (a, b, give_up), (successes, fails) = self._prior[entry], self._seen.get(entry, (0, 0))
        return a + successes, b + fails, give_up

    @property
    def changed(self) -> tuple[tuple[int, float, float], ...]:
        """Actions whose outcome probabilities were updated in this run.

        Each has its number in the file, and the weights of Success and of Fail in the belief about it.
        """
        return tuple((entry, *self.weights(entry)[:2]) for entry in sorted(self._seen))

    def chances(self) -> list[Chance | None]:
        """Return the mean outcome probabilities of each action by the present beliefs.

        An action has None if it only skips an element of a list over which the task repeats actions.
        """
        known = {entry: _mean(self.weights(entry)) for entry in self._prior}
        return [known.get(entry) for entry in self._entries]

    def drawn(self, seed: int = 0) -> list[list[Chance | None]]:
        """Return `DRAW_COUNT` random draws of the outcome probabilities of all actions of the network.

        They come from the beliefs' Dirichlet distributions; the same seed and beliefs give the same draws. An
        action that only skips an element of a list over which the task repeats actions has None.
        """
        order = list(self._prior)
        draws = np.random.default_rng([31, seed])
        weights = np.array([self.weights(entry) for entry in order])
        gammas: FloatArray = draws.standard_gamma(weights, (DRAW_COUNT, *weights.shape))
        shares = (gammas / gammas.sum(axis=2, keepdims=True)).tolist()
        rows = [
            {entry: Chance(success, give_up) for entry, (success, _, give_up) in zip(order, row, strict=True)}
            for row in shares
        ]
        return [[row.get(entry) for entry in self._entries] for row in rows]


def _mean(weights: tuple[float, float, float]) -> Chance:
    success, fail, give_up = weights
    total = success + fail + give_up
    return Chance(success / total, give_up / total)
