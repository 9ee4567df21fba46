"""What the libraries and FMUs say of themselves: options with defaults, ranges and choices, the variables of FMUs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from studies.compare.native import Options, option_rows
from studies.compare.scenario import Arrays, Named, given
from studies.compare.side import Side

PRESETS = {"ahrs": ("default",), "hrekf": ("default", "paper"), "ins_error": ("",), "turntable": ("",), "imu_mag_sensor": ("",)}


def options(side: Side, kind: str) -> Arrays:
    """Every option by its new name."""
    found, names = Arrays(), side.names
    for row in option_rows(side.library, kind).values():
        name = names.canonical("option", row.name)
        found[f"{name}.unit"] = np.array(row.unit)
        found[f"{name}.choices"] = np.array([names.canonical("choice", choice) for choice in row.choices], "U40")
        found[f"{name}.range"] = np.array([row.min, row.max, row.count, row.is_integer, row.min_is_open], float)
        for preset in PRESETS[kind]:
            found[f"{name}.default.{preset}"] = np.array(Options(side.library, kind, preset).get(row.name))
    return found


def magnetometer_defaults(side: Side) -> Arrays:
    struct = Options(side.library, "magnetometer").struct
    return side.library.numbers(struct)


def scenarios() -> Iterator[Named]:
    for kind in PRESETS:
        yield f"c/options/{kind}", given(options, kind)
    yield "c/options/magnetometer", magnetometer_defaults
