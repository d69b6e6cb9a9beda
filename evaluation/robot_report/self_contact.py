"""Estimate of the links that touch each other, by random postures of the arm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

POSTURE_SAMPLES = 200
ALWAYS_SHARE = 0.95
"""Share of random postures from which a pair counts as always touching: the default of MoveIt's Setup
Assistant.
"""

Pair = tuple[str, str]


@dataclass(frozen=True)
class SelfContact:
    """Self-contacts of a robot in random postures of its arm."""

    tried: int
    free: int
    """Number of postures without contact."""
    always: Sequence[Pair]
    """Pairs that touch in at least 95 % of the postures: their collision bodies overlap by design."""
    often: Sequence[tuple[Pair, float]]
    """Other pairs, with the share of postures in which they touch, the most frequent first."""
    always_shares: Sequence[float] = ()
    """Share of the postures in which each pair of `always` touches."""

    @property
    def words(self) -> str:
        """Number of random postures in which the robot touches itself, as one line of text."""
        return f"{self.tried - self.free} of {self.tried} random postures touch the robot itself"

    @property
    def pairs(self) -> list[str]:
        """Text for each pair of links that touch, with the share of random postures in which they do.

        Pairs that touch in every posture come first, then the others.
        """
        always = zip(self.always, self.always_shares, strict=True)
        return [touching_words(pair, share) for pair, share in (*always, *self.often)]


def touching_words(pair: Pair, share: float) -> str:
    """Return how often two links touch in random postures, as text; `share` is from 0 to 1."""
    return f"{pair[0]} touches {pair[1]} in {100.0 * share:.0f} % of postures"


def self_contact(arm: ArmModel, seed: int = 0) -> SelfContact:
    """Find the robot's self-contacts in `POSTURE_SAMPLES` random postures within the joints' limits."""
    checked = CollisionModel(arm)
    drawn = np.random.default_rng(seed).uniform(arm.lower, arm.upper, (POSTURE_SAMPLES, arm.dof))
    touching: Counter[Pair] = Counter()
    free = 0
    for q in drawn:
        pairs = {(min(pair), max(pair)) for pair in checked.contacts(q)}
        free += not pairs
        touching.update(pairs)
    always = sorted(pair for pair, count in touching.items() if count >= ALWAYS_SHARE * POSTURE_SAMPLES)
    others = sorted((-count, pair) for pair, count in touching.items() if pair not in always)
    shares = [touching[pair] / POSTURE_SAMPLES for pair in always]
    return SelfContact(
        POSTURE_SAMPLES, free, always, [(pair, -count / POSTURE_SAMPLES) for count, pair in others], shares
    )
