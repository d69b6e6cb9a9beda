"""Parts of localizations in checkpoints, also of earlier versions."""

from __future__ import annotations

import numpy as np

from handcart.backends.plain_values import attributes, to_plain
from handcart.backends.saved_state import NotAState
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.local_map import LocalMap
from handcart.robotics.navigation.odometry.bent_way import BentWay

from .crowd import Crowd


def completed(state: object) -> object:
    """Return the state of a localization, completed by default values of the parts that older versions did
    not save.
    """
    if not isinstance(state, dict):
        return state
    found = {"crowd": attributes(Crowd(), Crowd.STATE), **state}
    odometry = state.get("odometry")
    if isinstance(odometry, dict) and "_bent" not in odometry:
        found["odometry"] = {**odometry, "_bent": to_plain(BentWay.straight(), BentWay)}
    wheels = state.get("wheels")
    if isinstance(wheels, dict) and "_map_error" in wheels and "_by_scans" not in wheels:
        found["wheels"] = {**wheels, "_by_scans": None}
    return found


def local_map_of(echoes: list[float], pose: Pose2) -> LocalMap:
    """Rebuild a local map, drawn from scans of a base whose pose on the map is unknown, from a checkpoint.

    Args:
        echoes: x and y of each echo on the local map, alternating, in [m].
        pose: pose of the base on the local map.

    Raises:
        NotAState: a coordinate is missing.
    """
    if len(echoes) % 2:
        raise NotAState("no saved state: local map: pairs of numbers are needed")
    return LocalMap.of_echoes(np.array(echoes).reshape(-1, 2), pose)
