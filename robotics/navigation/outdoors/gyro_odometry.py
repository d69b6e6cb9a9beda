"""Odometry with wheels and three gyros on ground that isn't flat.

Ohki et al. (2012), eqs. 1 to 3, with the turn rates that belong to the angles: on a tilted base a gyro
turns around its own axis instead of the vertical. Frames are x forward, y left, z up, so a nose that rises
is a negative pitch, and eq. 3 has a minus.
"""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

REST_WINDOW_READINGS = 20  # readings that must be quiet before the base counts as standing: 0.5 s
QUIET_SIGMA_M_S2 = 0.1  # [m/s²] standard deviation of the accelerometers at rest
MAX_CREEP_M_S = 0.01  # [m/s] mean speed that a wheel may report while the base is at rest
# standard errors by which the vertical gyro may differ from its bias while the wheels creep
MAX_BIAS_SIGMAS = 4.0
BIAS_WANDER_RAD_S = math.radians(0.05)  # [rad/s] added for a bias that changes
BIAS_MEMORY_S = 20.0  # [s] over which a gyro's bias is averaged at rest: longer and it drifts away meanwhile


class Advance(NamedTuple):
    """Motion in one step of the localizer's Kalman filter, measured by wheels and vertical gyro."""

    forward: float
    """Level travel over ground, in [m]; negative backwards."""
    turn: float
    """Change of the heading, without the bias known so far, in [rad], positive to the left."""
    drift: float
    """Turn by the known bias, which was taken out of `turn`, in [rad]."""
    time: float
    """Duration in [s]."""
    rest: float
    """Part of `time` at rest, in [s]."""
    still: float
    """Turn measured by the vertical gyro at rest, caused by its bias alone, in [rad]."""


class GyroOdometry:
    """Odometry by the wheels' travel and the attitude from the gyros, whose bias is measured at each stop.

    At rest the gyros' mean is their bias, gravity gives roll and pitch, and the heading is constant. A base
    is at rest if its accelerometers have been quiet for half a second and its wheels have not moved. It is
    also at rest if its wheels have moved very slowly while the vertical gyro read only its bias; that
    distance counts as travel.
    """

    STATE: ClassVar = {"_state": FloatArray, "_felt": FloatArray, "_seen": FloatArray}
    """Attributes that change, with their types."""

    def __init__(self, start: Pose2 = Pose2(0.0, 0.0, 0.0), euler: bool = True) -> None:
        """Start at a pose; without `euler`, body rates count as rates of roll, pitch, yaw, like the paper."""
        self._euler = euler
        self._state = np.zeros(19)
        self._state[:2], self._state[3] = start[:2], start.theta
        self._felt = np.zeros((REST_WINDOW_READINGS, 8))
        self._seen = np.zeros(12)

    @property
    def pose(self) -> Pose2:
        """Pose of the base by odometry alone, in the frame of the pose from which the odometry started."""
        return Pose2(float(self._state[0]), float(self._state[1]), wrap(float(self._state[3])))

    @property
    def height(self) -> float:
        """Height of the base above the start by odometry alone, in [m]."""
        return float(self._state[2])

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base, in [rad]."""
        return float(self._state[4]), float(self._state[5])

    @property
    def bias(self) -> FloatArray:
        """Bias (3,) of the gyros in the base's axes, in [rad/s]."""
        return self._state[6:9].copy()

    @property
    def at_rest(self) -> bool:
        """True if the latest readings of wheels and inertial sensors show that the base is at rest."""
        return bool(self._state[10] > 0.0)

    @property
    def levelled(self) -> bool:
        """True if roll and pitch have been measured by gravity at rest."""
        return bool(self._state[6:9].any())

    @property
    def pending(self) -> float:
        """Time since the last call of `take`, in [s]."""
        return float(self._state[15])

    def update(self, rates: FloatArray, accelerations: FloatArray, wheels: FloatArray, dt: float) -> None:
        """Update the odometry by one period's readings; a reading that isn't finite is replaced by the
        reading before.

        Args:
            rates: (3,) angular velocities in the base's axes, in [rad/s].
            accelerations: (3,) specific force in the base's axes, gravity included (z up at rest), in [m/s²].
            wheels: (2,) travel of the left and right rear wheel in the period, in [m].
            dt: length of the period, in [s].
        """
        _update(self._state, self._felt, self._seen, rates, accelerations, wheels, dt, self._euler)

    def take(self) -> Advance:
        """Return the motion since the last call of this method, and start to sum up again."""
        sums = self._state[12:18].tolist()
        self._state[12:18] = 0.0
        return Advance(*sums)


@compiled
def _refresh(seen: FloatArray, at: int, values: FloatArray) -> FloatArray:
    """Return the latest finite values, remembered in `seen` from `at` on."""
    for k in range(len(values)):
        if math.isfinite(values[k]):
            seen[at + k] = values[k]
    return seen[at : at + len(values)]


@compiled
def _angle_rates(roll: float, pitch: float, rates: FloatArray) -> tuple[float, float, float, float]:
    """Return the rates of roll, pitch, yaw by body rates, and the derivative of the last by the third one."""
    sin, cos = math.sin(roll), math.cos(roll)
    across = rates[1] * sin + rates[2] * cos
    return (
        rates[0] + across * math.tan(pitch),
        rates[1] * cos - rates[2] * sin,
        across / math.cos(pitch),
        cos / math.cos(pitch),
    )


@compiled
def _levelled(force: FloatArray) -> tuple[float, float]:
    """Return roll and pitch, in [rad], by specific force (3,) at rest."""
    return math.atan2(force[1], force[2]), math.atan2(-force[0], math.hypot(force[1], force[2]))


@compiled
def _quiet(felt: FloatArray) -> bool:
    """Return True if each accelerometer (the first three columns) varies no more than at rest."""
    for axis in range(3):
        mean = felt[:, axis].mean()
        if ((felt[:, axis] - mean) ** 2).mean() > QUIET_SIGMA_M_S2 * QUIET_SIGMA_M_S2:
            return False
    return True


@compiled
def _creeps(felt: FloatArray, bias: float, known: bool, dt: float) -> bool:
    """Return True if wheels (columns 3, 4) and vertical gyro (7) read no more than is possible at rest."""
    count = len(felt)
    if max(abs(felt[:, 3].mean()), abs(felt[:, 4].mean())) > MAX_CREEP_M_S * dt:
        return False
    mean = felt[:, 7].mean()
    error = math.sqrt(((felt[:, 7] - mean) ** 2).sum() / (count - 1) / count)
    return not known or abs(mean - bias) <= MAX_BIAS_SIGMAS * error + BIAS_WANDER_RAD_S


@compiled
def _rest(state: FloatArray, felt: FloatArray, turning: FloatArray, force: FloatArray, dt: float) -> None:
    """Update at rest: the gyros' mean is their bias, gravity gives roll and pitch."""
    if state[10] == 0.0:  # it has come to rest: so have all readings that show it
        state[10] = (len(felt) - 1) * dt
        for axis in range(3):
            state[6 + axis], force[axis] = felt[:, 5 + axis].mean(), felt[:, axis].mean()
        state[4], state[5] = _levelled(force)
    state[10] += dt
    state[16] += dt
    state[17] += dt * turning[2]
    share = max(dt / state[10], dt / BIAS_MEMORY_S)
    for axis in range(3):
        state[6 + axis] += share * (turning[axis] - state[6 + axis])
    share = dt / state[10]
    roll, pitch = _levelled(force)
    state[4] += share * (roll - state[4])
    state[5] += share * (pitch - state[5])


@compiled
def _creep(state: FloatArray, travel: float) -> None:
    """Add the wheels' travel at rest to the position."""
    state[0] += travel * math.cos(state[5]) * math.cos(state[3])
    state[1] += travel * math.cos(state[5]) * math.sin(state[3])
    state[12] += travel * math.cos(state[5])


@compiled
def _middle_rates(
    state: FloatArray, free: FloatArray, dt: float, euler: bool
) -> tuple[float, float, float, float, float]:
    """Return the rates of roll, pitch and yaw at the middle of a period, the pitch there, and the derivative
    of the yaw rate by the third gyro.
    """
    if not euler:
        return free[0], free[1], free[2], state[5], 1.0
    roll_rate, pitch_rate, _, _ = _angle_rates(state[4], state[5], free)
    pitch = state[5] + 0.5 * dt * pitch_rate
    roll_rate, pitch_rate, yaw_rate, gain = _angle_rates(state[4] + 0.5 * dt * roll_rate, pitch, free)
    return roll_rate, pitch_rate, yaw_rate, pitch, gain


@compiled
def _drive(state: FloatArray, turning: FloatArray, travel: float, dt: float, euler: bool) -> None:
    """Move the pose by the travel of the wheels in a period, along the attitude from the gyros."""
    state[10] = 0.0
    roll_rate, pitch_rate, yaw_rate, pitch, gain = _middle_rates(state, turning - state[6:9], dt, euler)
    turn = dt * yaw_rate
    heading = state[3] + 0.5 * turn
    level = travel * math.cos(pitch)
    state[0] += level * math.cos(heading)  # Ohki (2012), eqs. 1 to 3, at the middle of the period
    state[1] += level * math.sin(heading)
    state[2] -= travel * math.sin(pitch)
    state[3] += turn
    state[4] += dt * roll_rate
    state[5] += dt * pitch_rate
    state[12] += level
    state[13] += turn
    state[14] += dt * gain * state[8]


@compiled
def _stands(state: FloatArray, felt: FloatArray, dt: float) -> bool:
    """Return True if the base is at rest, by the latest readings."""
    still = state[9] >= len(felt)
    known = state[6] != 0.0 or state[7] != 0.0 or state[8] != 0.0
    return bool((still or (state[18] >= len(felt) and _creeps(felt, state[8], known, dt))) and _quiet(felt))


@compiled
def _update(
    state: FloatArray,
    felt: FloatArray,
    seen: FloatArray,
    rates: FloatArray,
    accelerations: FloatArray,
    wheels: FloatArray,
    dt: float,
    euler: bool,
) -> None:
    """One period. State: x, y, z, yaw, roll, pitch; bias (3); still readings, time at rest, row; sums (6);
    readings.
    """
    turning = _refresh(seen, 0, rates)
    force = _refresh(seen, 3, accelerations)
    rolled = _refresh(seen, 6, wheels)
    travel = 0.5 * (rolled[0] + rolled[1])
    row = felt[int(state[11])]
    for i in range(3):  # no slices: numba compiles seconds of messages for them
        row[i], row[5 + i] = force[i], turning[i]
    row[3], row[4] = rolled[0], rolled[1]
    state[11] = (state[11] + 1) % len(felt)
    state[9] = state[9] + 1 if rolled[0] == 0.0 and rolled[1] == 0.0 else 0.0
    state[18] += 1
    state[15] += dt
    if _stands(state, felt, dt):
        _creep(state, travel)
        _rest(state, felt, turning, force, dt)
    else:
        _drive(state, turning, travel, dt, euler)
