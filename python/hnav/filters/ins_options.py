"""Options of the navigation filter, by name and grade of the sensors."""

from __future__ import annotations

from collections.abc import Mapping

from hnav.errors import HnavValueError
from hnav.native.library import enumerators
from hnav.native.options import OptionInfo, PresetOptions, option_rows

INS_PRESETS = enumerators("hnav_ins_preset", "HNAV_INS_")
"""Grades of inertial sensors: consumer, industrial, tactical, navigation."""


def ins_option_table() -> Mapping[str, OptionInfo]:
    """The options by name, in the library's order: unit, range, meaning."""
    return option_rows("ins")


class InsOptions(PresetOptions):
    """Options of the navigation filter, as attributes; ins_option_table() tells unit, range and meaning of each.

        InsOptions("industrial", car_across_m_s=0.1)

    preset: one of INS_PRESETS. values: options that differ from it. Raises HnavValueError for presets, names
    (UnknownOptionError) and values that do not exist.
    """

    def __init__(self, preset: str = "consumer", **values: object):
        if preset not in INS_PRESETS:
            raise HnavValueError("option", f"preset = {preset}: choose one of {', '.join(INS_PRESETS)}", "preset")
        super().__init__("ins", preset, INS_PRESETS.index(preset), values)

    def _arguments(self) -> tuple[str, ...]:
        return (self.preset,)
