"""Metres and degrees around a place on the earth."""

from __future__ import annotations

import numpy as np
from pyproj import Geod, Transformer

from cable_tracker.arrays import FloatArray
from cable_tracker.errors import ParameterError


class LocalFrame:
    """Metres east and north of a place on the earth: a plane that touches the ellipsoid there.

    Parameters
    ----------
    latitude, longitude : float
        Origin of the frame, WGS 84 [deg].

    Raises
    ------
    ParameterError
        There is no such place.
    """

    def __init__(self, latitude: float, longitude: float) -> None:
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0):
            raise ParameterError(
                f"datum: {latitude}, {longitude} is no place on the earth; give latitude,longitude"
                " in degrees, as 54.25,7.9"
            )
        longitude = (longitude + 180.0) % 360.0 - 180.0
        self.latitude, self.longitude = latitude, longitude
        self._to_local = Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad"
            " +step +proj=cart +ellps=WGS84"
            f" +step +proj=topocentric +ellps=WGS84 +lat_0={latitude!r} +lon_0={longitude!r} +h_0=0"
        )

    def from_degrees(self, latitude: FloatArray, longitude: FloatArray) -> FloatArray:
        """Return metres east and north of places on the ellipsoid, shape (N, 2)."""
        east, north, _ = self._to_local.transform(longitude, latitude, np.zeros_like(latitude))
        return np.column_stack((east, north))

    def distances(self, latitude: FloatArray, longitude: FloatArray) -> FloatArray:
        """Return the distances of places from the origin over the earth, shape (N,) [m]."""
        count = len(latitude)
        origin = np.full(count, self.longitude), np.full(count, self.latitude)
        return np.asarray(Geod(ellps="WGS84").inv(*origin, longitude, latitude)[2])

    def to_degrees(self, places: FloatArray) -> FloatArray:
        """Return latitude and longitude of metres east and north (N, 2), shape (N, 2)."""
        # Back to height 0: the plane leaves the ellipsoid by the square of the distance.
        up = -(places**2).sum(axis=1) / (2 * 6.371e6)
        return self.to_geodetic(np.column_stack((places, up)))[:, :2]

    def to_geodetic(self, places: FloatArray) -> FloatArray:
        """Return latitude, longitude [deg] and height above the ellipsoid [m], shape (N, 3).

        Parameters
        ----------
        places : FloatArray
            Metres east, north and up, shape (N, 3).
        """
        east, north, up = places.T
        longitude, latitude, height = self._to_local.transform(east, north, up, direction="INVERSE")
        return np.column_stack((latitude, longitude, height))
