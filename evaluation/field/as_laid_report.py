"""The as-laid report: where each sensor lies, by all that was seen before and after it was let go."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import orjson

from handcart.backends.robot.robot import Robot
from handcart.files.whole_file import write_whole
from handcart.networks.task.preparing import Prepared
from handcart.primitives.field.field_work import FieldWork
from handcart.primitives.field.target import Laid
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.robotics.geometry.earth_frame import EarthFrame
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

ELLIPSE_PROBABILITY = 0.95
ELLIPSE_CORNERS = 36  # of an ellipse
REPORT_NAME = "as_laid"


class AsLaid(NamedTuple):
    """Robot's estimate, with covariance, of the position at which it released a seismic sensor."""

    name: str
    place: FloatArray
    """Position (2,) of the sensor, x and y in the field's frame, in [m]."""
    covariance: FloatArray
    """Covariance (2, 2) of the position, in [m²]."""

    @property
    def ellipse(self) -> tuple[float, float, float]:
        """Half axes and direction of the ellipse that contains the sensor with a probability of 95 %.

        Large and small half axis in [m], and the large half axis' direction in the field's frame in [rad].
        """
        values, axes = np.linalg.eigh(self.covariance)
        scale = math.sqrt(-2.0 * math.log(1.0 - ELLIPSE_PROBABILITY))  # of two degrees of freedom
        small, large = (scale * math.sqrt(max(0.0, float(value))) for value in values)
        return large, small, math.atan2(float(axes[1, 1]), float(axes[0, 1]))

    @property
    def outline(self) -> FloatArray:
        """Closed outline (n, 2) of the 95 % confidence ellipse of a laid sensor's position, in the field's
        frame, in [m].
        """
        large, small, turn = self.ellipse
        angle = np.linspace(0.0, 2.0 * math.pi, ELLIPSE_CORNERS + 1)
        round_ = np.column_stack([large * np.cos(angle), small * np.sin(angle)])
        cos, sin = math.cos(turn), math.sin(turn)
        return np.asarray(self.place + round_ @ np.array([[cos, sin], [-sin, cos]]))


def as_laid(robot: Robot, model: WorldModel) -> list[AsLaid]:
    """Return the estimated positions of all released sensors.

    They are smoothed with all later readings if the localizer can do this, otherwise as estimated at release.
    """
    work = model.of(FieldWork)
    beliefs = robot.localization.smoothed()
    if len(beliefs) != len(work.laid):
        return [AsLaid(laid.name, np.array([laid.x, laid.y]), laid.spread) for laid in work.laid]
    return [
        _smoothed(laid, belief.mean[:3], belief.covariance[:3, :3])
        for laid, belief in zip(work.laid, beliefs, strict=True)
    ]


def _smoothed(laid: Laid, pose: FloatArray, covariance: FloatArray) -> AsLaid:
    place = Pose2(*pose.tolist()).apply(np.array([laid.beside])).reshape(2)
    away = place - pose[:2]
    by_pose = np.array([[1.0, 0.0, -away[1]], [0.0, 1.0, away[0]]])
    return AsLaid(laid.name, place, by_pose @ covariance @ by_pose.T)


def write_as_laid(prepared: Prepared, folder: Path) -> list[AsLaid]:
    """Write the estimated positions of all released sensors to `as_laid.csv`, and return them.

    If the field's origin on the Earth is known, write `as_laid.geojson` as well.
    """
    field, sensors = prepared.model.of(FieldWork).field, as_laid(prepared.robot, prepared.model)
    origin = None if field is None else field.origin
    earth = EarthFrame(origin.latitude_deg, origin.longitude_deg) if origin else None
    write_whole(folder / f"{REPORT_NAME}.csv", _csv(sensors, earth))
    if earth is not None:
        write_whole(
            folder / f"{REPORT_NAME}.geojson", orjson.dumps(_geojson(sensors, earth), option=_OPTIONS)
        )
    return sensors


_OPTIONS = orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE


def _csv(sensors: list[AsLaid], earth: EarthFrame | None) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    header = ["name", "x_m", "y_m", "half_axis_m", "other_half_axis_m", "axis_deg"]
    writer.writerow(header + (["latitude_deg", "longitude_deg"] if earth else []))
    for sensor in sensors:
        x, y = sensor.place.tolist()
        large, small, turn = sensor.ellipse
        row = [
            sensor.name,
            f"{x:.4f}",
            f"{y:.4f}",
            f"{large:.4f}",
            f"{small:.4f}",
            f"{math.degrees(turn):.1f}",
        ]
        if earth is not None:
            row += [f"{angle:.9f}" for angle in earth.to_earth(x, y)]
        writer.writerow(row)
    return text.getvalue()


def _geojson(sensors: list[AsLaid], earth: EarthFrame) -> dict[str, Any]:
    features = []
    for sensor in sensors:
        large, small, _ = sensor.ellipse
        properties = {
            "name": sensor.name,
            "half_axis_m": round(large, 4),
            "other_half_axis_m": round(small, 4),
        }
        point = {"type": "Point", "coordinates": _on_earth(sensor.place, earth)}
        ring = [_on_earth(corner, earth) for corner in sensor.outline]
        area = {"type": "Polygon", "coordinates": [ring]}
        features.append(
            {"type": "Feature", "geometry": point, "properties": {**properties, "what": "sensor"}}
        )
        features.append(
            {"type": "Feature", "geometry": area, "properties": {**properties, "what": "95 % ellipse"}}
        )
    return {"type": "FeatureCollection", "features": features}


def _on_earth(place: FloatArray, earth: EarthFrame) -> list[float]:
    latitude, longitude = earth.to_earth(float(place[0]), float(place[1]))
    return [round(longitude, 9), round(latitude, 9)]
