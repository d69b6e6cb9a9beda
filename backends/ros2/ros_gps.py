"""A satellite receiver, by `sensor_msgs/NavSatFix`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.gps import Fix
from handcart.backends.description.ros_spec import RosGpsSpec
from handcart.backends.live.live_gps import LiveGps
from handcart.robotics.geometry.earth_frame import EarthFrame

from .wire.messages import NO_FIX
from .wire.topic_sensor import TopicSensor

NO_FIX_WORDS = "the receiver has no fix"
UNKNOWN_COVARIANCE = 0


class RosGps(TopicSensor, LiveGps):
    """Satellite receiver whose fixes are received from a ROS topic.

    Positions are converted to a plane that touches the earth at the origin stated in the robot's file. A fix
    is returned only in the period in which it arrived.

    A receiver whose messages say that it has no fix is no fault. If for longer than `stale_ms` no message
    comes, or each is dropped for another reason, as when the receiver's time was set back, `fix` raises
    `StaleSensor`.
    """

    KIND = "sensor_msgs/NavSatFix"

    def fit(self, spec: RosGpsSpec, period_s: float = 1.0) -> None:
        """Prepare for the receiver of a robot's file, before the first fix.

        Args:
            spec: section with the point on Earth that is the origin of the positions.
            period_s: time between two fixes, in [s].
        """
        self._frame = EarthFrame(spec.origin_lat_deg, spec.origin_lon_deg)
        self._usual_sigma = spec.sigma_m
        self.is_silent_without_fix = spec.silent_without_fix
        self.set_period(period_s)

    @override
    def forget(self) -> None:
        super().forget()
        self._fix, self._answered, self._waits_since = None, None, self._now

    @override
    def _take_in(self) -> None:
        self._fix, rejected = None, self.rejected
        super()._take_in()
        if self.is_silent_without_fix and self.rejected == rejected and self.doubt in ("", NO_FIX_WORDS):
            self._answer(self._fix)

    @override
    def _refuse(self, message: Any) -> None:
        if self.doubt == NO_FIX_WORDS:
            self._answer(None)
        else:
            super()._refuse(message)

    @override
    def _wrong(self, message: Any) -> str:
        if message.status.status <= NO_FIX:
            return NO_FIX_WORDS
        if not (abs(message.latitude) <= 90.0 and abs(message.longitude) <= 180.0):  # also NaN
            return f"its place is {message.latitude:g}, {message.longitude:g} deg"
        sigma = self._sigma(message)
        return "" if 0.0 < sigma < math.inf else f"its sigma is {sigma:g} m; allowed: above 0"

    @override
    def _read(self, messages: list[Any]) -> None:
        last = messages[-1]
        place = self._frame.to_field(float(last.latitude), float(last.longitude))
        self._answer(Fix(np.array(place), self._sigma(last)))

    def _sigma(self, message: Any) -> float:
        """Return the receiver's sigma of the worse axis in [m]; the usual one if it states none."""
        if message.position_covariance_type == UNKNOWN_COVARIANCE:
            return self._usual_sigma
        worst = max(float(message.position_covariance[0]), float(message.position_covariance[4]))
        return math.sqrt(worst) if worst >= 0.0 else math.nan
