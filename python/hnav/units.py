"""Units by name, as what one of them is in SI."""

from __future__ import annotations

import re
from math import pi

G_M_S2 = 9.80665
"""Standard gravity: what accelerometers that say g mean."""

RAD_S_PER = {
    "rad/s": 1.0, "deg/s": pi / 180, "mdeg/s": pi / 180e3, "mrad/s": 1e-3, "rpm": pi / 30, "rev/s": 2 * pi, "deg/h": pi / 648e3,
}  # fmt: skip
"""Of a rate."""

M_S2_PER = {"m/s2": 1.0, "g": G_M_S2, "mg": 1e-3 * G_M_S2, "cm/s2": 1e-2, "mm/s2": 1e-3, "ft/s2": 0.3048}
"""Of a force, that is, force by mass."""

TESLA_PER = {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7, "au": 5e-5, "mT": 1e-3}
"""Of a magnetic field. au: arbitrary; the filter learns the strength anyway."""

S_PER = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
"""Of a time."""

SI_PER = {"gyro": RAD_S_PER, "accel": M_S2_PER, "mag": TESLA_PER, "time": S_PER}
"""By what is measured; the first unit of each is the SI one."""

SUSPECTED = {
    "gyro": ("rad/s", "deg/s", "mdeg/s"),
    "accel": ("m/s2", "g", "mg"),
    "mag": ("T", "uT", "nT", "G", "mG"),
    "time": ("s", "ms", "us", "ns"),
}
"""Units that files leave unsaid; another is named in the file, or by who reads it."""

COUNTED = re.compile(r"(\d+(?:\.\d+)?)(?:\s*/\s*(\d+(?:\.\d+)?))?\s*\*?\s*([a-zA-Z].*)")
"""What one count of a chip is: 1/131 deg/s, 0.061 mg."""


def si_per(quantity: str, unit: str) -> float:
    """What one of a unit is in SI; the unit may have a number before it, as 1/131 deg/s has. Raises KeyError for another text."""
    if unit in SI_PER[quantity]:
        return SI_PER[quantity][unit]
    match = COUNTED.fullmatch(unit)
    if match is None or not (divisor := float(match.group(2) or 1)):
        raise KeyError(unit)
    return float(match.group(1)) / divisor * SI_PER[quantity][match.group(3)]
