"""Speeds with which a base yields to people: never into a predicted path within the time to stop."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled_for

from .moving_tracks import STOOD_S
from .people import People, grown_radius, least_gaps

SPEED_SHARES = (1.0, 0.7, 0.45, 0.25, 0.1, 0.0)  # of a speed that are tried
REACTION_S = 0.3  # added to the time to stop
MOVING_GAP_M = 0.15  # to a moving person, when the base has stopped
STANDING_GAP_M = 0.05  # likewise to a person at rest
TURN_BACK_SPEED_M_S = 1.2  # with which a near person may turn back towards the base
STEP_OUT_SPEED_M_S = 0.4  # likewise for a person at rest for `SETTLED_S`
SETTLED_S = 3.5  # of rest, after which the person is expected to stay
TURN_BACK_S = 0.25  # added to the time to stop, because a track follows a turn so much later
CREEPING_M_S = 0.15  # with which the base may leave a person at rest
AWAY_GAP_M = 0.03  # down to which the base may move away from a person
STEP_S = 0.1  # between predicted instants
FORESEEN_S = 2.5  # of driving along a route
TOLERANCE_M = 0.05  # by which a faster motion may come nearer than the best one


def safe_share(
    pose: Pose2,
    command: tuple[float, float],
    people: People,
    radius: float,
    braking: float,
    period: float,
    last: float = 0.0,
) -> float:
    """Return the factor by which to reduce a speed command so that the base can stop before it meets people.

    With the reduced command the base stops before it comes near any person's predicted path.

    The base also has to stop in time for a nearby person who suddenly walks towards it. As long as it does
    if it brakes with `braking`, it is not slowed down by more: a person who walks as predicted never needs
    more.

    Args:
        pose: map_T_base.
        command: speed in [m/s] and turn rate in [rad/s].
        people: all persons.
        radius: radius of the footprint, in [m].
        braking: deceleration in [m/s²].
        period: control period, in [s].
        last: speed of the last period in the direction of the command, in [m/s]; below zero against it.

    Returns:
        0 to 1; 0 means to stop.
    """
    speed, turn = command
    if speed == 0.0 or not len(people.radii):
        return 1.0
    shares = _tried_shares((last - braking * period) / abs(speed))
    speeds = shares * abs(speed)
    lasts = period + speeds / braking + REACTION_S
    steps = [np.append(np.arange(0.0, end, STEP_S), end) for end in lasts.tolist()]
    times, counts = np.concatenate(steps), np.array([len(step) for step in steps])
    along = math.copysign(1.0, speed) * _braked(np.repeat(speeds, counts), braking, period, times)
    points, firsts = _on_arc(pose, turn / speed, along), np.concatenate([[0], np.cumsum(counts)])
    here, limits = np.array([pose.x, pose.y, radius]), np.empty((len(people.radii), 3))
    limits[:, 0] = np.where(people.moving, MOVING_GAP_M, STANDING_GAP_M)
    limits[:, 1] = np.where(people.stood_s < SETTLED_S, TURN_BACK_SPEED_M_S, STEP_OUT_SPEED_M_S)
    limits[:, 2] = people.stood_s
    first = _first_safe(speeds, braking, points, times, firsts, here, *people[:4], limits)
    return float(shares[first]) if first < len(shares) else 0.0


def _tried_shares(braked: float) -> FloatArray:
    """Return the shares of a speed that are tried, the largest first, with the one after a period of
    braking.
    """
    shares = np.array(SPEED_SHARES[:-1])
    if not 0.0 < braked < 1.0 or braked in SPEED_SHARES:
        return shares
    return np.asarray(np.insert(shares, int((shares > braked).sum()), braked))


@compiled_for(
    "(f8[::1], f8, f8[:,::1], f8[::1], i8[::1], f8[::1], "
    "f8[:,::1], f8[:,::1], f8[:,:,::1], f8[::1], f8[:,::1])"
)
def _first_safe(
    speeds: FloatArray,
    braking: float,
    points: FloatArray,
    times: FloatArray,
    firsts: IntArray,
    here: FloatArray,
    positions: FloatArray,
    velocities: FloatArray,
    covariances: FloatArray,
    radii: FloatArray,
    limits: FloatArray,
) -> int:
    """Return the index of the first speed that is safe; the number of speeds if none is.

    Args:
        speeds: (k,) speeds that are tried, in [m/s].
        braking: deceleration in [m/s²].
        points: (n, 2) positions of the base with all speeds, one speed after the other, on the map in [m].
        times: (n,) times of the positions, in [s].
        firsts: (k + 1,) speed i has points[firsts[i]:firsts[i + 1]].
        here: (3,) x and y of the base on the map and the radius of its footprint, in [m].
        positions: (p, 2), as in `People`; the next three as well.
        velocities: (p, 2).
        covariances: (p, 4, 4).
        radii: (p,).
        limits: (p, 3) gap to keep in [m], speed in [m/s] of a person who turns back, and time at rest in [s].
    """
    for i in range(len(speeds)):
        to_stop, safe = speeds[i] / braking, True
        for p in range(len(radii)):
            moves = velocities[p, 0] != 0.0 or velocities[p, 1] != 0.0
            size_now = grown_radius(covariances[p], 0.0, radii[p])
            gap = standing = near = np.inf
            for k in range(firsts[i], firsts[i + 1]):
                t = times[k] if moves else 0.0
                size = grown_radius(covariances[p], t, radii[p])
                x, y = positions[p, 0] + t * velocities[p, 0], positions[p, 1] + t * velocities[p, 1]
                away = math.sqrt((points[k, 0] - x) ** 2 + (points[k, 1] - y) ** 2)
                gap = min(gap, away - size - here[2])
                away = math.sqrt((here[0] - x) ** 2 + (here[1] - y) ** 2)
                standing = min(standing, away - size - here[2])
                away = math.sqrt(
                    (points[k, 0] - positions[p, 0]) ** 2 + (points[k, 1] - positions[p, 1]) ** 2
                )
                near = min(near, away - size_now - here[2])
            stood_s = limits[p, 2]
            leaves = gap >= standing - 1e-3 and (gap >= AWAY_GAP_M or stood_s >= STOOD_S)
            creeps = leaves and stood_s >= SETTLED_S and speeds[i] <= CREEPING_M_S
            in_time = near >= limits[p, 1] * (to_stop + TURN_BACK_S)
            safe = safe and (gap >= limits[p, 0] or leaves) and (in_time or creeps)
        if safe:
            return i
    return len(speeds)


def yielding_speed(ahead: FloatArray, speed: float, people: People, radius: float, keep: float) -> float:
    """Return the speed along a route at which the robot keeps a distance to people, in [m/s]; 0 means to
    wait.

    The result is the highest speed that keeps the distance `keep`. If no speed keeps it, the result is the
    highest of the speeds that keep about the largest distance. If the robot would touch a person at every
    speed, the result is 0; only motion that leads away from the person is still allowed.

    Args:
        ahead: (n, 2) route from the robot on, on the map, in [m].
        speed: top speed in [m/s].
        people: all persons.
        radius: radius of the footprint, in [m].
        keep: distance to keep from people, in [m].
    """
    if len(ahead) < 2 or not len(people.radii):
        return speed
    times = np.arange(0.0, FORESEEN_S + 1e-9, STEP_S)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(ahead, axis=0).T))])
    driven = np.array(SPEED_SHARES)[:, None] * speed * times[None]
    paths = np.stack([np.interp(driven, along, ahead[:, i]) for i in (0, 1)], axis=-1)
    gaps = least_gaps(paths, times, people, radius).min(axis=1)
    best = float(gaps.max())
    if best < 0.0 and gaps[-1] >= best - TOLERANCE_M:
        return 0.0
    wanted = min(keep, best - TOLERANCE_M)
    return SPEED_SHARES[int(np.argmax(gaps >= wanted))] * speed


def _braked(speeds: FloatArray, braking: float, period: float, times: FloatArray) -> FloatArray:
    """Return the distance (t,) driven at speeds (t,) for a period and then braked, in [m]."""
    after = np.clip(times - period, 0.0, speeds / braking)
    return np.asarray(speeds * np.minimum(times, period) + speeds * after - 0.5 * braking * after**2)


def _on_arc(pose: Pose2, curvature: float, along: FloatArray) -> FloatArray:
    """Return positions (t, 2) on the map after lengths (t,) of an arc, in [m]."""
    turned = curvature * along
    if abs(curvature) < 1e-6:
        local = np.column_stack([along, np.zeros_like(along)])
    else:
        local = np.column_stack([np.sin(turned), 1.0 - np.cos(turned)]) / curvature
    return np.asarray(pose.apply(local))
