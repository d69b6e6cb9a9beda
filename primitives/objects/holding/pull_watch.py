"""Pulls of a person at what the hand holds, by the force on the hand."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.motions.felt_force import FeltForce, awaited_force
from handcart.primitives.objects.knowledge import object_causes
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.numerics.arrays import FloatArray

PULL_TIME_S = 0.4  # that a force lasts at least; a bump is shorter
REST_READINGS = 10
NOISE_SIGMAS = 3.0  # of a single reading, that the least pull is above at least
STEADY_SHARE = 0.5  # of the least pull, that each reading of a pull has along it
LASTING_SHARE = 0.7  # of a pull, that the last reading has as the fingers open
CALM_SHARE = 0.5  # of the least pull: less is none
PUSHING_COSINE = -math.cos(math.radians(45.0))  # between a force and the way out: below, it pushes the hand


class PullWatch:
    """Detector of a person's pull, which it distinguishes from bumps, tremor, pushes and weight.

    A pull is a lasting force, in addition to the force at rest. Its mean over `PULL_TIME_S` must reach the
    threshold `least_n`, and every reading must be in the direction of the mean. A force towards the robot is
    a push, not a pull.
    """

    def __init__(self, robot: Robot, least_n: float) -> None:
        """Begin without a force at rest; `least_n` is the least pull, in [N]."""
        self._robot, self._least, self._felt = robot, least_n, FeltForce(robot)
        self._forces = deque[FloatArray](maxlen=max(2, math.ceil(PULL_TIME_S / robot.period - 1e-9)))
        self._rest, self._sigma = np.zeros(3), 0.0
        self.is_rested = False
        """True once the force was at rest where the hand is: only a later force counts as a pull."""

    def measure_rest(self, weight_n: float | None = None) -> Generator[None, None, None]:
        """Measure the force on the hand at rest, while nobody pulls at the held object.

        Args:
            weight_n: weight of the held object, in [N]; None if it is unknown.

        Raises:
            Discrepancy: the force's noise would hide the least pull that has to be detected; or the force
                differs from the weight by at least this pull, so that somebody seems to pull already.
        """
        mean, self._sigma = yield from self._readings()
        beside = 0.0 if weight_n is None else float(np.linalg.norm(mean + np.array([0.0, 0.0, weight_n])))
        if beside >= self._least:
            force = Measured("Arm", "force beside the weight", beside, self._least, "N")
            raise Discrepancy("somebody pulls already", measured=force, cause=object_causes.PULLED)
        self._rest = mean
        self._forces.clear()
        if not self._least >= NOISE_SIGMAS * self._sigma:
            noise = Measured(
                "Arm", "sigma of the force at rest", self._sigma, self._least / NOISE_SIGMAS, "N"
            )
            raise Discrepancy("the noise of the force hides a pull", measured=noise, cause=causes.UNSUITABLE)

    def rest_here(self) -> Generator[None, None, None]:
        """Measure the force at rest again where the hand is now, and set `is_rested`.

        If the force differs from the earlier force at rest, somebody may pull already: `is_rested` is False
        then, and the force at rest measured before stays valid. Thus a pull is not mistaken for weight.
        """
        mean, _ = yield from self._readings()
        self._forces.clear()
        self.is_rested = bool(np.linalg.norm(mean - self._rest) < CALM_SHARE * self._least)
        if self.is_rested:
            self._rest = mean

    def feel(self) -> None:
        """Read the force on the hand, subtract the force at rest, and append the result to the last readings.
        Set `is_rested` once these readings are calm.

        To be called once a period.

        Raises:
            Discrepancy: the force is not measured.
        """
        if (force := self._felt.read()) is not None:
            self._forces.append(self._in_base(force) - self._rest)
        if not self.is_rested and self.is_calm:
            self.is_rested = True

    @property
    def is_calm(self) -> bool:
        """True if the mean force on the hand over `PULL_TIME_S`, less the force at rest, is below the share
        `CALM_SHARE` of the least pull; False while there are fewer readings.
        """
        if len(self._forces) < (self._forces.maxlen or 0):
            return False
        return not float(np.linalg.norm(np.mean(self._forces, axis=0))) >= CALM_SHARE * self._least

    @property
    def is_strong(self) -> bool:
        """True if one of the last measured forces, in any direction, is at least the smallest force that
        counts as a person's pull on the held object.
        """
        return any(float(np.linalg.norm(force)) >= self._least for force in self._forces)

    def lasting(self, share: float = 1.0) -> FloatArray | None:
        """Return the mean force (3,) on the hand over `PULL_TIME_S`, in the base frame, in [N].

        None if the mean force is weaker than the limit, if the force fell below the share `STEADY_SHARE` of
        the limit in between, or if there are too few readings.

        Args:
            share: the limit, as a share of the least force that counts as a pull.
        """
        if len(self._forces) < (self._forces.maxlen or 0):
            return None
        forces = np.array(self._forces)
        mean = np.asarray(forces.mean(axis=0))
        size = float(np.linalg.norm(mean))
        if not size >= share * self._least:
            return None
        steady = bool(np.all(forces @ mean / size >= STEADY_SHARE * share * self._least))
        return mean if steady else None

    def pull(self) -> FloatArray | None:
        """Return the mean force (3,) of a pull, in the base frame, in [N]; None if nobody pulls.

        Raises:
            Discrepancy: the force sensor repeats its reading.
        """
        mean = self.lasting() if self.is_rested else None
        if mean is None:
            return None
        if self._sigma > 0.0 and not np.ptp(np.array(self._forces), axis=0).any():
            raise Discrepancy("the reading of the force stands still", cause=causes.SENSOR_FAULT)
        return None if _pushes(mean, self._robot.base_T("hand")[:3, 3]) else mean

    def lasts(self, pull: FloatArray) -> bool:
        """Return whether the last reading of the force, along the direction of a pull, is still at least
        `LASTING_SHARE` of the force of the pull.

        Args:
            pull: (3,) force of the pull when it began, in the base frame, in [N].
        """
        size = float(np.linalg.norm(pull))
        return bool(self._forces) and float(self._forces[-1] @ pull) / size >= LASTING_SHARE * size

    def _readings(self) -> Generator[None, None, tuple[FloatArray, float]]:
        """Return mean (3,) and standard deviation of some readings of the force, in [N]."""
        yield from settle(self._robot)
        forces: list[FloatArray] = []
        for _ in range(REST_READINGS):
            forces.append(self._in_base((yield from awaited_force(self._robot))))
            yield
        return np.asarray(np.mean(forces, axis=0)), float(np.std(forces, axis=0).max())

    def _in_base(self, force: FloatArray) -> FloatArray:
        """Return a force (3,) on the hand, in [N], turned from the hand's frame into that of the base."""
        return np.asarray(self._robot.base_T("hand")[:3, :3] @ force)


def direction_words(force: FloatArray) -> str:
    """Return the main direction of a force (3,) in the base frame, in [N], by a word such as "ahead"."""
    axis = int(np.abs(force).argmax())
    return (("back", "ahead"), ("right", "left"), ("down", "up"))[axis][int(force[axis] > 0.0)]


def _pushes(force: FloatArray, base_p_hand: FloatArray) -> bool:
    """Return whether a force (3,), in [N], pushes a hand at a position (3,), in [m], towards the robot.

    Both are in the base frame.
    """
    out = np.array([base_p_hand[0], base_p_hand[1], 0.0])
    cosine = float(force @ out) / max(float(np.linalg.norm(out) * np.linalg.norm(force)), 1e-9)
    return cosine < PUSHING_COSINE
