"""Latitude and longitude in the metres of a field."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


class EarthFrame:
    """Frame of a field on the ground, whose coordinates are computed from latitude and longitude on WGS 84.

    The projection is azimuthal equidistant around the field's origin: x is east, y north, in [m]. Its error
    is at most a millimetre within 10 km of the origin.
    """

    def __init__(self, latitude_deg: float, longitude_deg: float) -> None:
        """Set the projection's origin, in [deg]."""
        from pyproj import CRS, Transformer

        local = CRS.from_proj4(
            f"+proj=aeqd +lat_0={latitude_deg} +lon_0={longitude_deg} +datum=WGS84 +units=m"
        )
        self._to_field = Transformer.from_crs("EPSG:4326", local, always_xy=True)

    def to_field(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """Return x and y in the field's frame, in [m], of a latitude and a longitude in [deg]."""
        x, y = self._to_field.transform(longitude_deg, latitude_deg)
        return float(x), float(y)

    def points_to_field(self, latitudes_deg: FloatArray, longitudes_deg: FloatArray) -> FloatArray:
        """Return the places (n, 2) of latitudes and longitudes (n,) in [deg] as x and y in the field's frame,
        in [m].
        """
        return np.stack(self._to_field.transform(longitudes_deg, latitudes_deg), axis=1)

    def to_earth(self, x: float, y: float) -> tuple[float, float]:
        """Return latitude and longitude in [deg] of a place in the field.

        Args:
            x: east of the origin, in [m].
            y: north of the origin, in [m].
        """
        longitude, latitude = self._to_field.transform(x, y, direction="INVERSE")
        return float(latitude), float(longitude)
