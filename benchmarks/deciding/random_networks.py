"""Random networks with choices, loops and situations that Fails lead to."""

from __future__ import annotations

import random
from typing import NamedTuple

from handcart.networks.chains.chance import Chance
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.primitives.driving.modify import Modify

ANY_BINDING = Binding.of(Modify(place="x"))
NETWORK_FAMILIES = ("forward", "back", "anywhere")


class Drawn(NamedTuple):
    """A random network with its probabilities."""

    network: ActionNetwork
    chances: list[Chance | None]


def drawn(family: str, seed: int, most: int = 14) -> Drawn:
    """Draw a network of 5 to `most` situations, with 1 to 3 actions out of each.

    Args:
        family: `forward`: no way leads back; `back`: 15 % do, and 30 % of the Fails lead elsewhere;
            `anywhere`: all do as they like, and 20 % of the Fails lead elsewhere.
        seed: of the draw.
        most: maximum number of situations.
    """
    draws = random.Random(f"{family} {seed}")
    count = draws.randint(5, most)
    gives_up = draws.random() < 0.5
    actions, chances = list[Action](), list[Chance | None]()
    for here in range(count - 1):
        for number in range(draws.randint(1, 3)):
            there = min(count - 1, here + draws.randint(1, 3))
            if number and family == "anywhere":
                there = draws.randrange(count)
            elif number and family == "back" and draws.random() < 0.15:
                there = max(0, here - draws.randint(1, 3))
            share = {"forward": 0.0, "back": 0.3, "anywhere": 0.2}[family]
            on_fail = f"s{draws.randrange(count - 1)}" if draws.random() < share else None
            p = round(draws.uniform(0.3, 0.99), 3)
            give_up = round(draws.uniform(0.0, min(0.1, 1.0 - p)), 3) if gives_up else 0.0
            cost, attempts = round(draws.uniform(1.0, 60.0), 1), draws.randint(1, 4)
            actions.append(Action(f"s{here}", f"s{there}", ANY_BINDING, cost, attempts, on_fail))
            chances.append(Chance(p, give_up))
    names = [Situation(f"s{number}") for number in range(count)]
    return Drawn(ActionNetwork.build(names, actions, "s0", f"s{count - 1}"), chances)
