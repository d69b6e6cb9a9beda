"""The battery in a robot's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field
from typing_extensions import override

from handcart.backends.description.sensor_spec import SensorSpec
from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class ChargerSpec(FileModel):
    """Description of a charger, which charges the battery while the base is within `within_mm` of it."""

    x_m: float
    y_m: float
    """Position `x_m`, `y_m` of the charger on the map."""
    within_mm: Positive = 300.0
    """Largest distance of the base from the charger at which it charges."""
    power_w: Positive = 200.0
    """Power into the battery."""


class BatterySpec(SensorSpec):
    """Capacity of a battery, noise of its charge reading, and the power that a simulated robot draws
    from it.
    """

    kind: Literal["battery"] = "battery"

    capacity_wh: Positive
    """Energy of the full battery."""
    charge_percent: Annotated[float, Field(gt=0.0, le=100.0)] = 100.0
    """Charge at the start of a simulated run."""
    idle_w: NotNegative = 30.0
    """Power of the robot at rest."""
    drive_j_m: NotNegative = 100.0
    """Energy for each metre that the base drives."""
    turn_j_rad: NotNegative = 30.0
    """Energy for each radian that the base turns."""
    sigma_percent: NotNegative = 0.2
    """Sigma of a reading."""
    charger: ChargerSpec | None = None
    """Charger of the battery (default: none)."""

    @override
    def without_errors(self) -> Self:
        return self.model_copy(update={"sigma_percent": 0.0})
