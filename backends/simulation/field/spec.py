"""Field of sensors in a world's file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.backends.simulation.world.world_file import Coordinate, Millimetres
from handcart.files.models.model import FileModel


class SeismicSensorSpec(FileModel):
    """Seismic sensors that a robot carries in its magazine, to be laid out one after the other."""

    count: Annotated[int, Field(ge=0, le=2000)]
    size_mm: tuple[Millimetres, Millimetres, Millimetres] = (60.0, 60.0, 120.0)
    """Size along its x, y and z."""


class StationSpec(FileModel):
    """Place and accuracy of a total station that measures a reflector on the robot's hand for evaluation."""

    x_m: Coordinate
    y_m: Coordinate
    height_m: Annotated[float, Field(gt=0.0, le=10.0)] = 1.5
    period_s: Annotated[float, Field(gt=0.0)] = 0.3
    accuracy_mm: Annotated[float, Field(ge=0.0)] = 10.0
    """Twice the sigma of its readings, along each axis."""


class FieldSection(FileModel):
    """Section of a world's file with the seismic sensors in the robot's magazine, and the total station that
    measures the robot's hand for evaluation.
    """

    sensors: SeismicSensorSpec | None = None
    """Sensors in the robot's magazine."""
    total_station: StationSpec | None = None
