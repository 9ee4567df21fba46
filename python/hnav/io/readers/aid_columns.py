"""Columns of satellites, pressure, wheels and headings, by their names: lat_deg, gps_latitude, Longitude (deg), vel_n_m_s, hAcc, baro_hPa."""

from __future__ import annotations

import re
from typing import NamedTuple

from hnav.io.readers.unit_names import BEHIND_BRACKETS, abbreviated, words_in, words_of

ROLES = {
    "lat_deg": "angle", "lon_deg": "angle", "alt_m": "length", "vn": "velocity", "ve": "velocity", "vd": "velocity",
    "ground_speed": "velocity", "course_deg": "angle", "sigma_h": "length", "sigma_v": "length", "sigma_n": "length", "sigma_e": "length", "sigma_vel": "velocity",
    "pressure_pa": "pressure", "speed_m_s": "velocity", "antenna_heading_deg": "angle",
    "sigma_heading_deg": "angle", "received_s": "time", "fix_type": "fix", "fix_quality": "fix", "fix_status": "fix",
    "variance_e": "variance", "variance_n": "variance", "variance_u": "variance", "variance_type": "fix",
}  # fmt: skip
"""Possible contents of a column, and the quantity of each."""

PER = {
    "angle": {"deg": 1.0, "rad": 57.29577951308232, "1e7deg": 1e-7, "1e5deg": 1e-5},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048},
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1 / 3.6, "kn": 1852 / 3600, "mph": 0.44704},
    "pressure": {"Pa": 1.0, "hPa": 100.0, "kPa": 1000.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "variance": {"m2": 1.0},
    "fix": {"": 1.0},
}
"""Units of each quantity as factors to the first, which is assumed unless the name states another."""

_SPELLED = {
    "angle": {"deg": "deg degree degrees d decimaldegree decimaldegrees", "rad": "rad radian radians r", "1e7deg": "1e7 e7 degx1e7 1e7deg 1e-7deg",
              "1e5deg": "1e5 e5 degx1e5 1e5deg 1e-5deg"},
    "length": {"m": "m meter meters metre metres", "mm": "mm", "cm": "cm", "km": "km", "ft": "ft feet"},
    "velocity": {"m/s": "m/s ms mps mpersec ms-1", "mm/s": "mm/s mms", "cm/s": "cm/s cms", "km/h": "km/h kmh kph kmph",
                 "kn": "kn kt kts knot knots", "mph": "mph"},
    "pressure": {"Pa": "pa pascal", "hPa": "hpa mbar mb millibar", "kPa": "kpa"},
    "time": {"s": "s sec", "ms": "ms", "us": "us", "ns": "ns"},
    "variance": {"m2": "m2 m^2"}, "fix": {},
}  # fmt: skip
_UNITS = {
    quantity: {word: unit for unit, words in units.items() for word in words.split()} for quantity, units in _SPELLED.items()
}

_NAMES = {
    "lat_deg": "lat latit latitude",
    "lon_deg": "lon lng long longitude",
    "alt_m": "alt altitude height hgt altwgs84 altitudewgs84 heightwgs84 ellipsoidheight heightellipsoid altellipsoid altitudeellipsoid ellipsoidalheight hell althae heighthae hae elevation ele hmsl altitudemsl heightmsl altmsl altitudesealevel",
    "vn": "vn vnorth northv velocityn velocitynorth veln velnorth northvelocity speednorth northspeed vnorthing",
    "ve": "ve veast eastv velocitye velocityeast vele veleast eastvelocity speedeast eastspeed",
    "vd": "vd vdown downv velocityd velocitydown veld veldown downvelocity speeddown downspeed",
    "-vd": "vu vup velocityu velocityup velu velup upvelocity climbrate",
    "ground_speed": "speed groundspeed speedoverground sog velocity vel gspeed",
    "course_deg": "course bearing direction track courseoverground cog groundcourse headmot",
    "sigma_h": "sigmah hacc hacuracy horizontalaccuracy haccuracy eph sigmahorizontal stdh hsigma accuracy",
    "sigma_v": "sigmav vacc verticalaccuracy vaccuracy epv sigmavertical stdv vsigma sdheight heightsd altitudestd stdaltitude sdu",
    "sigma_n": "sigman sdnorth northsd latitudestd stdlatitude sdn",
    "sigma_e": "sigmae sdeast eastsd longitudestd stdlongitude sde",
    "sigma_vel": "sigmavel sacc speedaccuracy velocityaccuracy velacc sigmavelocity stdvel",
    "pressure_pa": "pressure staticpressure baro barometer barometricpressure baropressure pres press airpressure atmosphericpressure",
    "speed_m_s": "wheelspeed odospeed odometerspeed vehiclespeed wheelvelocity odometry speedwheel",
    # A heading without more words may be a truth or another filter's answer: it is none.
    "antenna_heading_deg": "antennaheading dualantennaheading headingdualantenna baselineheading headingbaseline rtkheading relheading",
    "sigma_heading_deg": "sigmaheading headingsigma accheading headingaccuracy headingacc stdheading headingstd",
    "received_s": "received receivedat arrival arrived timereceived treceived",
}
_STEMS = {stem: role for role, stems in _NAMES.items() for stem in stems.split()}
_OF_FIXES = {
    "fixtype": "fix_type", "fix": "fix_quality", "fixquality": "fix_quality", "statusstatus": "fix_status", "fixstatus": "fix_quality",
    "positioncovariance0": "variance_e", "positioncovariance4": "variance_n", "positioncovariance8": "variance_u",
    "positioncovariancetype": "variance_type",
}  # fmt: skip
"""Whole names, but for their first words: of receivers, and NavSatFix of ROS, whose matrix is of east, north, up."""
_BEFORE_FIXES = words_of("gps gnss")
LEAST_OF_A_FIX = {"fix_type": 2, "fix_quality": 1, "fix_status": 0}
"""The smallest number of a fix: of u-blox, PX4 and MAVLink, where 1 is none by satellites; of NMEA and flags; of ROS."""
_FILLERS = words_of("above gps gnss fix satellite satellites nav pos position location ned raw data sensor ublox ubx pvt")
# These names alone are too short, or too common, to identify a column.
_ONLY_WITH_UNIT_OR_FILLER = words_of("velocity vel accuracy odometry track direction height long ele press baro")
ABOVE_SEA = re.compile("msl|egm96|sea.?level|geoid|orthometric", re.IGNORECASE)
ABOVE_ELLIPSOID = re.compile("wgs.?84|ellips|hae", re.IGNORECASE)
"""Names of heights that state what they are above."""
_DATUMS = {"wgs84", "egm96", "msl", "ellipsoid"}
"""What brackets may hold beside a unit."""
_SQUEEZED = str.maketrans(dict.fromkeys(' ^*_·"', "") | {"°": "deg", "²": "2", "⁻": "-", "¹": "1"})
INSTANCE = re.compile(r"\(\d+\):")
"""GPS(0):Lat[degrees] of DJI."""


class AidColumn(NamedTuple):
    """The content of a column: one of ROLES, its unit if the name states it, and its sign."""

    role: str
    unit: str | None
    sign: float


def aid_column(name: str) -> AidColumn | None:
    """The content of a column of this name; None when it has no role."""
    text = INSTANCE.sub(":", name.strip().strip('"').lstrip("#% "))
    if text in ROLES:
        return AidColumn(text, next(iter(PER[ROLES[text]])), 1.0)
    stated = ""
    if match := BEHIND_BRACKETS.fullmatch(text):
        text, stated = match.groups()
        stated = "" if stated.lower() in _DATUMS else stated
    tokens = words_in(text.replace("°", "deg"))
    if role := _OF_FIXES.get("".join(token for token in tokens if token not in _BEFORE_FIXES)):
        return AidColumn(role, None, 1.0)
    bare = [token for token in tokens if token not in _FILLERS]
    for end in range(len(bare), 0, -1):
        stem, behind = "".join(bare[:end]), "".join(bare[end:])
        if role := _STEMS.get(stem):
            sure = len(bare) < len(tokens) or stem not in _ONLY_WITH_UNIT_OR_FILLER
            return _of_role(role, stated, behind, sure)
    return None


def _of_role(role: str, stated: str, behind: str, sure: bool) -> AidColumn | None:
    """stated: the unit in brackets; behind: the rest of the name, which can only be a unit."""
    quantity = ROLES[role.lstrip("-")]
    unit = aid_unit(quantity, stated) or aid_unit(quantity, behind)
    if (behind and not aid_unit(quantity, behind)) or (stated and not unit) or not (sure or unit):
        return None
    return AidColumn(role.lstrip("-"), unit, -1.0 if role.startswith("-") else 1.0)


def aid_unit(quantity: str, text: str) -> str | None:
    """The unit of a quantity that a text names, if it does."""
    squeezed = text.strip().translate(_SQUEEZED).lower()
    return _UNITS[quantity].get(squeezed) or _UNITS[quantity].get(abbreviated(squeezed))
