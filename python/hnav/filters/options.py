"""Options of the AHRS, the HREKF and the INS, by name and preset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hnav.errors import HnavValueError
from hnav.filters.declination import field_of_place
from hnav.io.sensors import GRADES, read_grade
from hnav.native.library import enumerators
from hnav.native.options import OptionInfo, OptionSet, option_rows

FILTERS = {"hrekf": ("default", "paper"), "ahrs": ("default",)}
"""The attitude filters, and the presets of each."""
INS_PRESETS = enumerators("hnav_ins_preset", "HNAV_INS_")
"""Those of the INS, grades of inertial sensors: consumer, industrial, tactical, navigation."""
BODIES = enumerators("hnav_body", "HNAV_BODY_")
"""Choices of the option body of the AHRS and the INS: any, hand, walker, car, ship, quadrotor, aircraft."""
CAR_ACROSS_M_S = 0.1
"""car_across_m_s of the INS for a car: tyres on a road. The INS uses it with body = "car" (with_body in c_src/ins/model.hpp)."""
PRESETS = {**FILTERS, "ins": INS_PRESETS}


def option_table(filter: str) -> Mapping[str, OptionInfo]:
    """The options of a filter by name, in the library's order. Raises HnavValueError for other filters."""
    if filter not in PRESETS:
        raise HnavValueError("option", f"filter = {filter}: choose one of {', '.join(PRESETS)}", "filter")
    return option_rows(filter)


def options_of_place(filter: str, place_and_date: Sequence[float] | None) -> dict[str, object]:
    """What Options sets for a place and a date; the INS takes the declination only. Raises HnavValueError, HnavRuntimeError."""
    if place_and_date is None:
        return {}
    if len(place_and_date) != 4:
        wanted = "latitude_rad, longitude_rad, height_m, year"
        raise HnavValueError("size", f"place_and_date has {len(place_and_date)} numbers: give {wanted}", "place_and_date")
    of_place = field_of_place(*place_and_date)
    return {name: value for name, value in of_place.items() if name in option_table(filter)}


def options_of_sensor(filter: str, sensor: str | Path | None) -> dict[str, object]:
    """What Options sets for a grade or a file sensor.json. Raises HnavError."""
    if sensor is None:
        return {}
    if filter not in FILTERS and str(sensor) in GRADES:
        raise HnavValueError(
            "option", f"sensor = {sensor}: {filter} has grades as presets: {', '.join(PRESETS[filter])}", "sensor"
        )
    return read_grade(sensor).options(filter)


class Options(OptionSet):
    """Options of a filter, as attributes; option_table(filter) has unit, range and meaning of each.

        Options("hrekf", "paper", gamma_mode="kl", q_body_sensor=[1, 0, 0, 0])
        Options("ins", "industrial", body="car")

    filter: "ahrs", "hrekf" or "ins". preset: one of PRESETS[filter], or "default" for the first. place_and_date: latitude and
    longitude in rad, height above the ellipsoid in m, decimal year; sets the reference field and the declination by the World
    Magnetic Model. sensor: a file sensor.json (models/sensors/README.md), or a grade (consumer, industrial, tactical) of the
    attitude filters; the INS has grades as presets. values: options that differ from all these. Raises HnavValueError for filters, presets,
    names (UnknownOptionError), values and places that do not exist, HnavError for a file that holds no sensor.
    """

    def __init__(self, filter: str, preset: str = "default", place_and_date: Any = None, sensor: Any = None, **values: object):
        option_table(filter)
        presets = PRESETS[filter]
        preset = presets[0] if preset == "default" else preset
        if preset not in presets:
            raise HnavValueError("option", f"preset = {preset}: {filter} has {', '.join(presets)}", "preset")
        self.__dict__["_preset"] = preset
        self._fill(
            filter, presets.index(preset), options_of_sensor(filter, sensor) | options_of_place(filter, place_and_date) | values
        )

    @property
    def filter(self) -> str:
        """The filter that the options are of."""
        return str(self._options)

    @property
    def preset(self) -> str:
        """The preset that the options started from."""
        return str(self._preset)

    def _arguments(self) -> tuple[str, ...]:
        return (self.filter,) if self.preset == PRESETS[self.filter][0] else (self.filter, self.preset)
