"""Radio beacons in a robot's file or a log's header."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field
from typing_extensions import override

from .sensor_spec import SensorSpec

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
BeaconPlace = tuple[float, float, float]
"""Position of a radio, x, y and height above the ground, in [m]; of a beacon on the map, of the tag in the
base frame.
"""


class BeaconsSpec(SensorSpec):
    """Fixed radio beacons, and the robot's own radio, which measures its distance from them."""

    kind: Literal["beacons"] = "beacons"

    places_m: Annotated[dict[str, BeaconPlace], Field(min_length=1)]
    """Position of each beacon, by its name; at least three that are not collinear determine the robot's
    position.
    """
    tag_m: BeaconPlace = (0.0, 0.0, 1.0)
    """Position of the robot's own radio in the base frame."""
    period_s: Positive = 0.2
    """Time between two measurements, each of all beacons."""
    reach_m: Positive = 60.0
    """Distance beyond which a beacon isn't heard."""
    sigma_m: NotNegative = 0.1
    """Sigma of a range."""
    bias_m: NotNegative = 0.3
    """Sigma of the constant error of all ranges to one beacon."""
    scale_percent: NotNegative = 1.0
    """Sigma of the scale error common to all ranges."""
    bias_walk_m_rt_s: NotNegative = 0.01
    """Assumed random walk of the constant error after one second; it grows with the square root of time. The
    simulated value is in the world's file.
    """

    @override
    def without_errors(self) -> Self:
        sure = dict.fromkeys(("sigma_m", "bias_m", "scale_percent", "bias_walk_m_rt_s"), 0.0)
        return self.model_copy(update=sure)
