"""The Earth as an ellipsoid that turns (WGS 84), in NumPy: places, axes, gravity; any number of rows at once.

Places are n x 3: latitude, longitude in rad, height above the ellipsoid in m. Positions are Earth-centred, Earth-fixed, in m.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

RATE_RAD_S = 7.292115e-5
EQUATOR_M = 6378137.0
FLATTENING = 1 / 298.257223563
ECCENTRICITY2 = FLATTENING * (2 - FLATTENING)


def position_of(place: Array) -> Array:
    """n x 3: Earth-centred, Earth-fixed."""
    latitude, longitude, height = np.moveaxis(np.asarray(place, float), -1, 0)
    sine, cosine = np.sin(latitude), np.cos(latitude)
    normal = EQUATOR_M / np.sqrt(1 - ECCENTRICITY2 * sine**2)
    return np.stack(
        [
            (normal + height) * cosine * np.cos(longitude),
            (normal + height) * cosine * np.sin(longitude),
            (normal * (1 - ECCENTRICITY2) + height) * sine,
        ],
        -1,
    )


def place_of(position: Array) -> Array:
    """n x 3: latitude, longitude, height, by one step of Bowring's."""
    x, y, z = np.moveaxis(np.asarray(position, float), -1, 0)
    polar = EQUATOR_M * np.sqrt(1 - ECCENTRICITY2)
    axis = np.hypot(x, y)
    u = np.arctan2(z * EQUATOR_M, axis * polar)
    up = z + ECCENTRICITY2 / (1 - ECCENTRICITY2) * polar * np.sin(u) ** 3
    latitude = np.arctan2(up, axis - ECCENTRICITY2 * EQUATOR_M * np.cos(u) ** 3)
    root = np.sqrt(1 - ECCENTRICITY2 * np.sin(latitude) ** 2)
    return np.stack([latitude, np.arctan2(y, x), axis * np.cos(latitude) + z * np.sin(latitude) - EQUATOR_M * root], -1)


def axes_at(place: Array) -> Array:
    """n x 3 x 3: columns are north, east, down at the place in Earth-fixed axes."""
    latitude, longitude, _ = np.moveaxis(np.asarray(place, float), -1, 0)
    sl, cl, so, co = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    rows = [[-sl * co, -so, -cl * co], [-sl * so, co, -cl * so], [cl, 0 * cl, -sl]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def gravity_m_s2(latitude: Array, height: Array) -> Array:
    """Somigliana on the ellipsoid, second order in height; it holds the centrifugal part."""
    s2, h = np.sin(latitude) ** 2, height / EQUATOR_M
    ground = 9.7803253359 * (1 + 0.00193185265241 * s2) / np.sqrt(1 - ECCENTRICITY2 * s2)
    strength: Array = ground * (1 - 2 * h * (1 + FLATTENING + 0.00344978650684 - 2 * FLATTENING * s2) + 3 * h**2)
    return strength


def gravity_at(position: Array) -> Array:
    """n x 3: gravity in Earth-fixed axes, along the normal of the ellipsoid at each position."""
    place = place_of(position)
    down: Array = axes_at(place)[..., 2]
    return down * gravity_m_s2(place[..., 0], place[..., 2])[..., None]
