"""Check by ground truth that the hand holds the thing that a primitive's Success claims."""

from __future__ import annotations

from handcart.backends.ground_truth import GroundTruth
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.preconditions.hand_use import Hand

from .survey import Claim

HAND_NAME = "hand"


def things_held(truth: GroundTruth) -> set[str]:
    """Return the names of the bodies that the hand carries."""
    return {name for name, body in truth.bodies.items() if body.support == HAND_NAME}


def false_hold(claim: Claim, model: WorldModel) -> list[str]:
    """Return a message if the hand holds other things than a Success claims, otherwise an empty list.

    Args:
        claim: a Success, with the ground truth before and after the action.
        model: the robot's knowledge after the action.
    """
    before, after = things_held(claim.before), things_held(claim.after)
    match claim.primitive.hand_use().after:
        case Hand.ANY:
            return []
        case Hand.SAME:
            wanted = before
        case Hand.EMPTY:
            wanted = set()
        case Hand.FULL:
            thing = claim.primitive.thing(model.view(claim.primitive))
            wanted = {thing} if thing else (after if len(after) == 1 else {"something"})
    return [] if after == wanted else [f"the hand holds {_listed(after)}, not {_listed(wanted)}"]


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names)) or "nothing"
