"""Options of the attitude filters, by name and preset."""

from __future__ import annotations

from collections.abc import Mapping

from hnav.errors import HnavValueError
from hnav.native.library import PRESETS
from hnav.native.options import OptionInfo, PresetOptions, option_rows

FILTERS = {"hrekf": ("default", "paper"), "ahrs": ("default",)}
"""The filters, and the presets of each."""


def option_table(filter: str) -> Mapping[str, OptionInfo]:
    """The options of a filter by name, in the library's order. Raises HnavValueError for other filters."""
    if filter not in FILTERS:
        raise HnavValueError("option", f"filter = {filter}: choose one of {', '.join(FILTERS)}", "filter")
    return option_rows(filter)


def checked_preset(filter: str, preset: str) -> int:
    """The number of a preset that the filter has. Raises HnavValueError for filters and presets that do not exist."""
    option_table(filter)
    if preset not in FILTERS[filter]:
        raise HnavValueError("option", f"preset = {preset}: {filter} has {', '.join(FILTERS[filter])}", "preset")
    return PRESETS.index(preset)


def parse_setting(text: str) -> tuple[str, str]:
    """Name and value of "NAME=VALUE". Raises HnavValueError."""
    name, separator, value = text.partition("=")
    if not (separator and name and value):
        raise HnavValueError("option", f"setting = {text}: write NAME=VALUE", "setting")
    return name, value


class Options(PresetOptions):
    """Options of an attitude filter, as attributes; option_table(filter) tells unit, range and meaning of each.

        Options("hrekf", "paper", gamma_mode="kl", q_body_sensor=[1, 0, 0, 0])

    filter: "ahrs" or "hrekf". preset: one of FILTERS[filter]. values: options that differ from the preset. Raises
    HnavValueError for filters, presets, names (UnknownOptionError) and values that do not exist.
    """

    def __init__(self, filter: str, preset: str = "default", **values: object):
        super().__init__(filter, preset, checked_preset(filter, preset), values)

    def _arguments(self) -> tuple[str, ...]:
        return (self.filter,) if self.preset == "default" else (self.filter, self.preset)
