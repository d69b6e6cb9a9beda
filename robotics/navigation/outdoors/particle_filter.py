"""The particle filter of Ohki et al. (2012), section IV-B."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.navigation.outdoors.heading_bank import KNOWN_HEADING_SIGMA_RAD
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

from .fix_monitor import FixMonitor
from .lost_track import LostTrack


class ParticleErrors(NamedTuple):
    """Standard deviations of motion, start pose and fixes that the particle filter assumes.

    Ohki et al. (2012) state only the error of fixes, `gps`.
    """

    forward: float = 0.10
    """Relative error of each step's length."""
    turn: float = math.radians(0.5) / math.sqrt(10.0)
    """Random walk of the heading by distance, in [rad/√m]."""
    start_position: float = 0.05
    """Error of the position at the start, an axis, in [m]."""
    start_heading: float = math.radians(1.0)
    """Error of the heading at the start, in [rad]; infinite if the heading is unknown."""
    gps: float = 1.0
    """Error of a fix, an axis, in [m]."""
    along: float = 0.0
    """Random walk of the travel by distance, in [m/√m], because wheels slip alike for some metres."""
    turn_time: float = 0.0
    """Random walk of the heading by time, in [rad/√s], caused by an unknown gyro bias."""
    gps_slow: float = 0.0
    """Lasting error of the fixes, an axis, in [m], which averaging does not reduce."""


class ParticleFilter(FieldLocalizer):
    """Particle filter for the pose of a base outdoors, after Ohki et al. (2012).

    It has 1,024 particles and makes ten steps a second. Some things differ from the paper. Particles are
    averaged in every step, also without a new fix. Headings are averaged on the circle. A fix counts as an
    unusual jump if it is off by more than five sigmas of fix and particles together. A series of fixes with a
    common error is rejected as well (see `FixMonitor`). If rejected fixes agree with each other and with the
    odometry, the filter starts again from them (see `LostTrack`). Without a known heading it starts with
    particles of all headings.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        **FieldLocalizer.STATE,
        "_particles": FloatArray,
        "_mean": FloatArray,
        "_covariance": FloatArray,
        "_lost": LostTrack,
        "_monitor": FixMonitor,
        "restarts": int,
        "dice": tuple[int, int, int, int],
    }

    def __init__(
        self,
        start: Pose2,
        errors: ParticleErrors = ParticleErrors(),
        count: int = 1024,
        seed: int = 0,
        euler: bool = True,
        heading_sigma: float = KNOWN_HEADING_SIGMA_RAD,
    ) -> None:
        """Start at a pose.

        Args:
            start: world_T_base.
            errors: errors that the filter assumes.
            count: number of particles.
            seed: seed of the random errors.
            euler: False to integrate the gyros as printed in the paper.
            heading_sigma: sigma that the particles' heading has to reach before it counts as known, in [rad].
        """
        super().__init__(start, euler)
        self._heading_sigma = heading_sigma
        self._errors = errors
        self._rng = np.random.default_rng(seed)
        self._lost, self._monitor = LostTrack(), FixMonitor()
        self.restarts = 0
        """Number of restarts of the filter from rejected fixes."""
        about = math.isinf(errors.start_heading)
        heading = 0.0 if about else errors.start_heading
        spread = np.array([errors.start_position, errors.start_position, heading])
        drawn = self._rng.standard_normal((3, count))
        self._particles = np.array(start)[:, None] + spread[:, None] * drawn  # below them: at the origin
        if about:
            self._particles[2] = 2.0 * math.pi / count * np.arange(count)
        self._particles = np.vstack([self._particles, self._particles])
        self._mean, self._covariance = _average(self._particles)

    @property
    def heading_known(self) -> bool:
        """True if the standard deviation of the particles' headings is so small that the heading counts as
        known.
        """
        return bool(self._covariance[2, 2] <= self._heading_sigma**2)

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of the particles' x, y in [m] and heading in [rad], in the field's frame."""
        return self._covariance.copy()

    @property
    def dice(self) -> tuple[int, int, int, int]:
        """State of the random generator PCG64, to continue the same random numbers after a checkpoint.

        It consists of PCG64's state and increment (128 bits each), a flag that is 1 if numpy has stored a
        32-bit number for the next call, and this number.
        """
        state = self._rng.bit_generator.state
        return state["state"]["state"], state["state"]["inc"], state["has_uint32"], state["uinteger"]

    @dice.setter
    def dice(self, state: tuple[int, int, int, int]) -> None:
        here, step, left_over, bits = state
        self._rng.bit_generator.state = {
            "bit_generator": "PCG64",
            "state": {"state": here, "inc": step},
            "has_uint32": left_over,
            "uinteger": bits,
        }

    @property
    def particles(self) -> FloatArray:
        """Particles (3, n) in the field's frame: x, y in [m], heading in [rad]."""
        return self._particles[:3].copy()

    def _set_origin(self) -> None:
        self._particles[3:] = self._particles[:3]

    def _relative_pose(self) -> Belief:
        x, y, turn = self._particles[:3] - self._particles[3:]
        cos, sin = np.cos(self._particles[5]), np.sin(self._particles[5])
        return Belief(*_average(np.stack([cos * x + sin * y, cos * y - sin * x, turn])))

    def _estimate(self) -> Pose2:
        return Pose2(float(self._mean[0]), float(self._mean[1]), wrap(float(self._mean[2])))

    def _advance(self, advance: Advance) -> None:
        if advance.forward != 0.0 or advance.turn != 0.0:
            errors, way = self._errors, abs(advance.forward)
            across = math.hypot(errors.turn * math.sqrt(way), errors.turn_time * math.sqrt(advance.time))
            along = math.hypot(errors.forward * way, errors.along * math.sqrt(way))
            _predict(self._particles, self._rng, advance.forward, advance.turn, along, across)
        self._mean, self._covariance = _average(self._particles)

    def _fix(self, position: FloatArray, sigma: float | None) -> bool:
        sigma = math.hypot(self._errors.gps if sigma is None else sigma, self._errors.gps_slow)
        away = position - self._mean[:2]
        cloud = self._covariance[:2, :2]
        if self._monitor.doubting:
            believed = self._monitor.cleared(away, cloud, sigma**2)
        else:
            suspects = self._monitor.suspects(away, cloud + sigma**2 * np.eye(2))
            believed = suspects == 0
            self._lost.doubt(max(0, suspects - 1))
        self.refusal = "" if believed else f"{float(np.hypot(*away)):.2f} m off"
        if believed and not _resample(self._particles, self._rng, position[0], position[1], sigma):
            believed, self.refusal = False, "no particle could have given it"
        self._lost.take(self._odometry.pose, position, believed)
        if not believed:
            believed = self._start_again(sigma)
        self._mean, self._covariance = _average(self._particles)
        return believed

    def _start_again(self, sigma: float) -> bool:
        """Start again from the pose on which the refused fixes agree; return whether they agree."""
        found = self._lost.found(sigma, self._estimate(), math.sqrt(float(self._covariance[2, 2])))
        if found is None:
            return False
        drawn = self._rng.standard_normal((3, self._particles.shape[1]))
        root = np.linalg.cholesky(found.covariance + 1e-9 * np.eye(3))
        self._particles[:3] = np.array(found.pose)[:, None] + root @ drawn
        self.restarts += 1
        self._monitor.reset()
        return True


@compiled
def _predict(
    particles: FloatArray, rng: np.random.Generator, forward: float, turn: float, along: float, across: float
) -> None:
    """Phase 2: move the particles by the odometry's step with random errors.

    Rows of `particles` (6, n) are x, y in [m] and heading in [rad], now and at the origin.
    """
    for i in range(particles.shape[1]):
        way = forward + along * rng.standard_normal()
        bend = turn + across * rng.standard_normal()
        heading = particles[2, i] + 0.5 * bend
        particles[0, i] += way * math.cos(heading)
        particles[1, i] += way * math.sin(heading)
        particles[2, i] += bend


@compiled
def _resample(particles: FloatArray, rng: np.random.Generator, x: float, y: float, sigma: float) -> bool:
    """Weigh by a fix (phase 4, eq. 4) and resample (phase 5); return False if no particle explains the fix.

    Draws are multinomial. n sorted uniform numbers are sums of n + 1 exponential ones, divided by the
    total.
    """
    count = particles.shape[1]
    total = 0.0
    sums, draws = np.empty(count), np.empty(count + 1)
    for i in range(count):
        square = (particles[0, i] - x) ** 2 + (particles[1, i] - y) ** 2
        total += math.exp(-0.5 * square / sigma**2)
        sums[i] = total
    if total < 1e-200:
        return False
    end = 0.0
    for i in range(count + 1):
        end += rng.standard_exponential()
        draws[i] = end
    old = particles.copy()
    source = 0
    for i in range(count):
        wanted = draws[i] / end * total
        while source < count - 1 and sums[source] < wanted:
            source += 1
        particles[:, i] = old[:, source]
    return True


@compiled
def _average(particles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Phase 6: mean (3,), the heading's on the circle, and covariance (3, 3)."""
    count = particles.shape[1]
    mean = np.zeros(3)
    around = particles[2, 0]
    for i in range(count):
        mean[0] += particles[0, i]
        mean[1] += particles[1, i]
    mean /= count
    cos, sin = 0.0, 0.0
    for i in range(count):
        cos += math.cos(particles[2, i] - around)
        sin += math.sin(particles[2, i] - around)
    mean[2] = around + math.atan2(sin, cos)
    covariance = np.zeros((3, 3))
    for i in range(count):
        dx, dy = particles[0, i] - mean[0], particles[1, i] - mean[1]
        turn = particles[2, i] - mean[2]
        turn -= 2.0 * math.pi * round(turn / (2.0 * math.pi))
        covariance[0, 0] += dx * dx
        covariance[0, 1] += dx * dy
        covariance[0, 2] += dx * turn
        covariance[1, 1] += dy * dy
        covariance[1, 2] += dy * turn
        covariance[2, 2] += turn * turn
    covariance /= count
    covariance[1, 0], covariance[2, 0], covariance[2, 1] = (
        covariance[0, 1],
        covariance[0, 2],
        covariance[1, 2],
    )
    return mean, covariance
