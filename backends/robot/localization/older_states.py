"""States of localizations in checkpoints of earlier versions."""

from __future__ import annotations

from handcart.backends.plain_values import attributes, to_plain
from handcart.robotics.navigation.localization.bent_way import BentWay

from .crowd import Crowd


def completed(state: object) -> object:
    """Return the state of a localization with the parts that older checkpoints lack."""
    if not isinstance(state, dict):
        return state
    found = {"crowd": attributes(Crowd(), Crowd.STATE), **state}
    odometry = state.get("odometry")
    if isinstance(odometry, dict) and "_bent" not in odometry:
        found["odometry"] = {**odometry, "_bent": to_plain(BentWay.straight(), BentWay)}
    return found
