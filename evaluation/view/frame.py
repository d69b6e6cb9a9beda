"""What is drawn at one time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from handcart.evaluation.playback.playback import Moment
from handcart.evaluation.playback.scenery import ThingShape

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """A run at one time, with what was sensed last. What is None stays as it is drawn."""

    moment: Moment
    situation: str
    things: Mapping[str, Array | None]
    """By name: (7,) world_T_thing; None: it isn't there yet. Those left out stay where they are."""
    new: tuple[ThingShape, ...] = ()
    """Things that weren't drawn before."""
    rays: Array | None = None
    """(n, 2, 3) in [m] in the world: from the range sensor to what it hit."""
    cloud: Array | None = None
    """(p, 3) particles: x, y in [m], heading in [rad]."""
    picture: bytes | None = None
    """JPEG, of the camera."""
    planned: Array | None = None
    """(n, 2) in [m]: the path that the action means to drive."""
    bumped: Array | None = None
    """(n, 2) in [m]: where the base ran into something that no sensor shows."""
    driven: Array | None = None
    """(n, 2) in [m]: the path up to now."""
    restored: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(n,) which points of `driven` are of a way back."""
