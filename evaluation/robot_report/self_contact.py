"""Which of a robot's links touch each other, however its arm stands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

SAMPLES = 200
ALWAYS = 0.95
"""Share of random postures in which a pair "always" touches: the default of MoveIt's Setup Assistant."""

Pair = tuple[str, str]


@dataclass(frozen=True)
class SelfContact:
    """What random postures of an arm touch: the robot itself, or the arm."""

    tried: int
    free: int
    """Postures that touch nothing."""
    always: Sequence[Pair]
    """Pairs that touch in all but 5 % of the postures: their bodies overlap by the way they are drawn."""
    often: Sequence[tuple[Pair, float]]
    """Other pairs, with the share of postures in which they touch, the most frequent first."""
    always_shares: Sequence[float] = ()
    """Of postures in which the pairs of `always` touch."""

    @property
    def words(self) -> str:
        """In one line."""
        return f"{self.tried - self.free} of {self.tried} random postures touch the robot itself"

    @property
    def pairs(self) -> list[str]:
        """Each pair that touches, with its share of the postures, in words; the most frequent first."""
        always = zip(self.always, self.always_shares, strict=True)
        return [touching_words(pair, share) for pair, share in (*always, *self.often)]


def touching_words(pair: Pair, share: float) -> str:
    """How often two links touch, as people read it."""
    return f"{pair[0]} touches {pair[1]} in {100.0 * share:.0f} % of postures"


def self_contact(arm: ArmModel, seed: int = 0) -> SelfContact:
    """Try `SAMPLES` postures, even over the joints' limits."""
    checked = CollisionModel(arm)
    drawn = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (SAMPLES, arm.dof))
    touching: Counter[Pair] = Counter()
    free = 0
    for q in drawn:
        pairs = {(min(pair), max(pair)) for pair in checked.contacts(q)}
        free += not pairs
        touching.update(pairs)
    always = sorted(pair for pair, count in touching.items() if count >= ALWAYS * SAMPLES)
    others = sorted((-count, pair) for pair, count in touching.items() if pair not in always)
    shares = [touching[pair] / SAMPLES for pair in always]
    return SelfContact(SAMPLES, free, always, [(pair, -count / SAMPLES) for count, pair in others], shares)
