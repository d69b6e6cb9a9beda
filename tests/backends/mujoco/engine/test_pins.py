"""Points at which MuJoCo holds a thing in the hand."""

from __future__ import annotations

import pytest

from handcart.backends.mujoco.engine.pins import MAX_PIN_POINTS, Pins
from handcart.backends.physics.engine.engine import Pinned


@pytest.mark.parametrize("count", [0, MAX_PIN_POINTS - 1, MAX_PIN_POINTS + 1])
def test_pins_hold_at_as_many_points_as_their_forces_are_read(count: int) -> None:
    points = ((0.0, 0.0, 0.0),) * count
    with pytest.raises(ValueError, match=f"needed: {MAX_PIN_POINTS}"):
        Pins().close(None, None, Pinned(0, 0, 1, points, points, 10.0), 0, 1)
