"""Content of the view at one time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from handcart.evaluation.viewing.playback.playback import PlaybackMoment
from handcart.evaluation.viewing.playback.scenery import ThingShape
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class Frame:
    """State of a run at one time, to be drawn. A part of the drawing stays unchanged if its field is None."""

    moment: PlaybackMoment
    situation: str
    things: Mapping[str, FloatArray | None]
    """(7,) world_T_thing by name, as x, y, z in [m] and unit quaternion w, x, y, z; None hides a thing that
    is not there yet. Things that are not listed keep their pose.
    """
    new: tuple[ThingShape, ...] = ()
    """Things that have not been drawn before."""
    rays: FloatArray | None = None
    """(n, 2, 3) lidar rays in the world, in [m]: from the lidar to the point that was hit."""
    cloud: FloatArray | None = None
    """(p, 3) particles of the localization: x, y in [m], heading in [rad]."""
    picture: bytes | None = None
    """Camera picture as JPEG."""
    planned: FloatArray | None = None
    """(n, 2) path that the action plans to drive, in [m]."""
    bumped: FloatArray | None = None
    """(n, 2) points where the base hit something that no sensor sees, in [m]."""
    driven: FloatArray | None = None
    """(n, 2) path driven so far, in [m]."""
    restored: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(n,) whether each point of `driven` was driven while restoring."""
    people: FloatArray | None = None
    """(p, 7) tracked people, each x, y in [m], velocity x, y in [m/s], and xx, xy, yy of the covariance in
    [m²].
    """
