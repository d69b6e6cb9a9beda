"""Ramps as a drive plans them."""

from __future__ import annotations

import math

_CYCLE = 1e-3  # of a drive's own control loop [s]


def ramp(velocity: float, target: float, rate: float, seconds: float) -> tuple[float, float]:
    """Return the signed travel and the final velocity of a ramp at constant acceleration, in [m] and [m/s] or
    [rad] and [rad/s].

    Args:
        velocity: velocity at first, in [m/s] or [rad/s].
        target: velocity at which the ramp ends and stays, in the same unit.
        rate: acceleration, above zero, in [m/s²] or [rad/s²].
        seconds: duration, in [s].
    """
    needs = abs(target - velocity) / rate if rate > 0.0 else math.inf
    if needs <= seconds:
        return (velocity + target) / 2 * needs + target * (seconds - needs), target
    end = velocity + math.copysign(rate * seconds, target - velocity)
    return (velocity + end) / 2 * seconds, end


def approach(
    way: float, velocity: float, top: float, rates: tuple[float, float], seconds: float
) -> tuple[float, float]:
    """Compute a motion towards a point, with a trapezoidal velocity profile and any initial velocity.

    Args:
        way: position of the point minus position of the axis, in [m] or [rad].
        velocity: velocity at first, in [m/s] or [rad/s].
        top: largest speed, in [m/s] or [rad/s].
        rates: acceleration and deceleration, in [m/s²] or [rad/s²].
        seconds: duration, in [s].

    Returns:
        The distance that remains after `seconds` to the point, signed like `way`, in [m] or [rad], and the
        velocity at the end, in [m/s] or [rad/s].
    """
    for _ in range(round(seconds / _CYCLE)):
        if way == 0.0 and velocity == 0.0:
            break
        way, velocity = _cycle(way, velocity, top, rates)
    return way, velocity


def _cycle(way: float, velocity: float, top: float, rates: tuple[float, float]) -> tuple[float, float]:
    up, down = rates
    # The speed from which it just stops at the point, in whole cycles.
    step = down * _CYCLE
    stops = math.sqrt(step * step / 4 + 2.0 * down * abs(way)) - step / 2
    goal = math.copysign(min(top, stops), way)
    faster = abs(goal) > abs(velocity) and goal * velocity >= 0.0
    most = (up if faster else down) * _CYCLE
    velocity += max(-most, min(most, goal - velocity))
    moved = velocity * _CYCLE
    if way * velocity > 0.0 and abs(way) <= abs(moved) + step * _CYCLE and abs(velocity) <= 2.0 * step:
        return 0.0, 0.0
    return way - moved, velocity
