"""Localization by wheels, gyros and GPS, by several Kalman filters with different noise models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.odometry.watched_moment import Belief, spread_about
from handcart.robotics.navigation.outdoors.field_kalman import FieldKalman
from handcart.robotics.navigation.outdoors.field_localizer import (
    CONSISTENCY_WINDOW,
    FieldLocalizer,
    Inconsistency,
    inconsistency_of,
)
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE, FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import Advance
from handcart.robotics.navigation.outdoors.heading_bank import KNOWN_HEADING_SIGMA_RAD, HeadingBank
from handcart.robotics.navigation.outdoors.noise_hypotheses import NoiseHypothesis, noise_hypotheses
from handcart.robotics.navigation.outdoors.smoothing import TrackRecord
from handcart.robotics.numerics.arrays import FloatArray

# of the weight of other claims: the stated sky is more likely than a worse one
CAUTION_SHARES = (0.015, 0.3)
WORSENING_PROBABILITY = 1e-4  # with each fix a world may become a worse one; never a better one
UNKNOWN_HEADING_SIGMA_RAD = 1.0  # [rad] of a start heading's sigma: a larger one counts as unknown
MIN_WEIGHT = 1e-130  # of a weight: two hours of good fixes bring it back


class GpsFilter(FieldLocalizer):
    """Outdoor localizer by several Kalman filters with different noise models, weighted by the fixes'
    likelihoods.

    This is multiple-model estimation (Magill, 1965). A filter with a single noise model reports too small a
    covariance if the real noise is different. Here each noise model is a hypothesis. The given one has by far
    the largest weight at the start; fixes that are more likely under another hypothesis raise the weight of
    that hypothesis. Pose and covariance are those of the weighted mixture.
    """

    REST_PERIOD: ClassVar[float] = 1.0
    """Duration of a filter step at rest, in [s]; nothing but slow errors change then."""
    STATE: ClassVar[Mapping[str, Any]] = {
        **FieldLocalizer.STATE,
        "_weights": FloatArray,
        "_searching": bool,
        "log_likelihood": float,
        "_clock": float,
        "_squares": list[tuple[float, float | None]],
    }

    def __init__(
        self,
        start: Pose2,
        noise: FieldNoise = REFERENCE_NOISE,
        start_position: float = 0.05,
        record: bool = False,
        supposed: Sequence[NoiseHypothesis] | None = None,
        heading_sigma: float = KNOWN_HEADING_SIGMA_RAD,
    ) -> None:
        """Start at a pose whose position is right to `start_position` [m] an axis.

        Args:
            start: world_T_base.
            noise: given noise model of wheels, gyros and GNSS.
            start_position: sigma in [m].
            record: keep the data that `smoothed` needs.
            supposed: hypotheses; `noise_hypotheses` of `noise` if None.
            heading_sigma: sigma that an unknown start heading must reach before it counts as known, in
                [rad].
        """
        super().__init__(start)
        self._noise, self._begun, self._start_position = noise, start, start_position
        supposed = noise_hypotheses(noise) if supposed is None else supposed
        self._bank = HeadingBank(start, supposed[0].noise, start_position)
        self._searching = noise.start_heading > UNKNOWN_HEADING_SIGMA_RAD
        self._heading_sigma = heading_sigma
        self._clock = 0.0  # [s]
        self._squares: list[
            tuple[float, float | None]
        ] = []  # times of fixes, and squares as in `Fixed`; None if refused
        shares = np.array([hypothesis.share for hypothesis in supposed])
        self._weights: FloatArray = shares / shares.sum()
        self._worse = [hypothesis.worse for hypothesis in supposed]
        worse = np.array([[a.may_become(b) for a in supposed] for b in supposed])
        self._becomes = np.eye(len(shares)) + WORSENING_PROBABILITY * self._weights[:, None] * worse
        self.log_likelihood = 0.0
        self.filters = [
            FieldKalman(
                start, _computable(hypothesis.noise), start_position, TrackRecord() if record else None
            )
            for hypothesis in supposed
        ]
        """Kalman filters, one for each hypothesis."""
        self._here: Pose2 | None = None
        self._spread: FloatArray | None = None
        """(3, 3) covariance of the mixture, cached like its pose `_here`; None after a change."""

    @property
    def weights(self) -> FloatArray:
        """Probabilities (k,) of the hypotheses on the noise, given all readings so far."""
        return self._weights.copy()

    @property
    def best(self) -> FieldKalman:
        """Kalman filter whose noise model (its hypothesis) is the most likely one so far."""
        return self.filters[int(np.argmax(self._weights))]

    @property
    def refused(self) -> int:
        """Number of fixes rejected as outliers by the filter that has the most likely noise model."""
        return self.best.refused

    @property
    def restarts(self) -> int:
        """Number of times that the filter of the most likely hypothesis began again from rejected fixes."""
        return self.best.restarts

    @property
    def heading_known(self) -> bool:
        """True if the heading was given at the start, or has been found from fixes since then."""
        return not self._searching

    @property
    def meanwhile(self) -> Belief | None:
        """Mean (3,) and covariance (3, 3) of the pose while its heading is unknown; None once it is known.

        They are those of a mixture of filters for all headings: x, y in the field's frame in [m], heading in
        [rad].
        """
        if not self._searching:
            return None
        mean, covariance = self._bank.belief
        return Belief(mean[:3], covariance[:3, :3])

    @property
    @override
    def inconsistency(self) -> Inconsistency | None:
        return inconsistency_of(self._squares)

    @property
    @override
    def parts(self) -> list[FieldKalman | HeadingBank]:
        return [*self.filters, self._bank]

    @property
    @override
    def covariance(self) -> FloatArray:
        if self._searching:
            away = self._start_position**2 + self._estimate().distance(self._begun) ** 2
            return np.diag([away, away, math.pi**2 / 3.0])
        if self._spread is None:
            self._spread = self._mixed([filter_.belief for filter_ in self.filters], 3).covariance
            self._spread.flags.writeable = False
        return self._spread

    @override
    def mark(self) -> Belief:
        self._flush()
        return self._mixed([filter_.mark() for filter_ in self.filters])

    def smoothed(self) -> list[Belief]:
        """Return the states at all moments that the caller marked, estimated from all readings before and
        after them.

        The list is empty if no data were recorded.
        """
        each = [one.smoothed() for one in self.filters]
        return [self._mixed(list(moment)) for moment in zip(*each, strict=True)]

    def _set_origin(self) -> None:
        for filter_ in self.filters:
            filter_.set_origin()

    def _relative_pose(self) -> Belief:
        return self._mixed([filter_.relative_pose for filter_ in self.filters])

    def _estimate(self) -> Pose2:
        if self._searching:
            return self._since
        if self._here is None:
            x, y, heading = _mean([filter_.belief.mean for filter_ in self.filters], self._weights)[
                :3
            ].tolist()
            self._here = Pose2(x, y, wrap(heading))
        return self._here

    @override
    def forget_derived(self) -> None:
        self._here, self._spread = None, None

    def _advance(self, advance: Advance) -> None:
        self.forget_derived()
        self._clock += advance.time
        if self._searching:
            self._bank.advance(advance)
        for filter_ in self.filters:
            filter_.advance(advance)

    def _fix(self, position: FloatArray, sigma: float | None) -> bool:
        self.forget_derived()
        if self._searching:
            self._find_heading(position, self._noise.gps_white if sigma is None else sigma)
            return True
        fixed = [filter_.fix(position, sigma, self._odometry) for filter_ in self.filters]
        likely = np.array([one.log_likelihood for one in fixed])
        weights = self._becomes @ self._weights * np.exp(likely - likely.max())
        self._weights = np.maximum(weights / weights.sum(), MIN_WEIGHT)
        best = fixed[int(np.argmax(self._weights))]
        self.refusal = best.why
        self.log_likelihood += best.log_likelihood
        self._squares.append((self._clock, best.square if best.believed else None))
        while self._squares[0][0] < self._clock - CONSISTENCY_WINDOW:
            del self._squares[0]
        return best.believed

    def _mixed(self, beliefs: list[Belief], first: int | None = None) -> Belief:
        """Return the mixture's mean and covariance, of all states or of the `first` few.

        A worse GNSS condition looks like the better one for long, by lack of evidence: the covariance is
        chosen on the safe side.
        """
        mean = _mean([belief.mean for belief in beliefs], self._weights)[:first]
        away = np.array([belief.mean[:first] for belief in beliefs]) - mean
        away[:, 2] = (away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
        moved = self._weights * np.where(np.arange(len(beliefs)) == 0, *CAUTION_SHARES)
        cautious = self._weights - moved
        np.add.at(cautious, self._worse, moved)
        covariances = np.array([belief.covariance[:first, :first] for belief in beliefs])
        return Belief(mean, spread_about(away, self._weights, covariances, cautious))

    def _find_heading(self, position: FloatArray, sigma: float) -> None:
        """Take in a fix before the heading is known; the filters begin when it is."""
        self.log_likelihood += self._bank.fix(position, sigma, self._odometry)
        if self._bank.is_known(self._heading_sigma):
            for filter_ in self.filters:
                filter_.begin_with(self._bank.belief, self.filters[0].noise)
            self._searching = False


def _computable(noise: FieldNoise) -> FieldNoise:
    """Return the noise with a finite sigma of the start heading, for use until a heading is found."""
    return noise._replace(start_heading=min(noise.start_heading, UNKNOWN_HEADING_SIGMA_RAD))


def _mean(means: list[FloatArray], weights: FloatArray) -> FloatArray:
    """Return the weighted mean of states (n,), with headings averaged on the circle."""
    stacked = np.array(means)
    about = stacked[int(np.argmax(weights)), 2]
    stacked[:, 2] = about + (stacked[:, 2] - about + math.pi) % (2.0 * math.pi) - math.pi
    return np.asarray(weights @ stacked)
