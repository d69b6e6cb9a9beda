"""A satellite receiver, by `sensor_msgs/NavSatFix`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.description.ros_spec import RosGpsSpec
from handcart.backends.live.sensor_errors import StaleSensor
from handcart.robotics.geometry.earth_frame import EarthFrame

from .wire.topic_sensor import TopicSensor

NO_FIX = -1
"""`status.status` of a message without a fix."""
NO_FIX_WORDS = "the receiver has no fix"
UNKNOWN_COVARIANCE = 0


class RosGps(TopicSensor, Gps):
    """Satellite receiver whose fixes are received from a ROS topic.

    Positions are converted to a plane that touches the earth at the origin stated in the robot's file. A fix
    is returned only in the period in which it arrived.

    A receiver without a fix is no fault. If for longer than `stale_ms` each message is dropped for another
    reason, as when the receiver's time was set back, `fix` raises `StaleSensor`.
    """

    KIND = "sensor_msgs/NavSatFix"

    def fit(self, spec: RosGpsSpec) -> None:
        """Set the point on Earth that is the origin of the positions, before the first fix."""
        self._frame = EarthFrame(spec.origin_lat_deg, spec.origin_lon_deg)
        self._usual_sigma = spec.sigma_m
        self._fix: Fix | None = None
        self._refused_since: float | None = None

    @override
    def fix(self) -> Fix | None:
        if self._refused_since is not None and self._now - self._refused_since > self._stale:
            raise StaleSensor(self.name, self.age, self._stale, self.doubt)
        return self._fix

    @override
    def _take_in(self) -> None:
        self._fix, rejected = None, self.rejected
        super()._take_in()
        if self._fix is not None or self.doubt == NO_FIX_WORDS:
            self._refused_since = None
        elif self.rejected > rejected and self._refused_since is None:
            self._refused_since = self._now

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
        self._fix = Fix(np.array(place), self._sigma(last))

    def _sigma(self, message: Any) -> float:
        """Return the receiver's sigma of the worse axis in [m]; the usual one if it states none."""
        if message.position_covariance_type == UNKNOWN_COVARIANCE:
            return self._usual_sigma
        worst = max(float(message.position_covariance[0]), float(message.position_covariance[4]))
        return math.sqrt(worst) if worst >= 0.0 else math.nan
