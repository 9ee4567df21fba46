"""Findings about an implausible recording."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hnav.io.recordings import Recording
from hnav.units import SI_PER

SEVERAL = re.compile(r",(?=\s*[a-z]\w*=)")
"""Separator between gx=1 and gy=2; axes contain commas too."""
Samples = Mapping[str, tuple[np.ndarray, np.ndarray]]
"""Times and vectors by sensor."""


MEANINGLESS = {
    "unit": ("gyro", "accel", "time", "position"), "axes": ("gyro", "accel", "mag"), "sign": ("accel",), "scale": ("gyro",), "gravity_removed": ("accel",),
    "all_zero": ("accel",), "no_samples": ("gyro", "accel"),
}  # fmt: skip
"""Faults by code and sensor that leave no attitude, or one with a sigma that is far too small. On BROAD trials such
recordings give errors of 14 to 180 deg with sigmas of 1 to 6 deg. A field with a wrong unit, of zeros or with hard iron is
not among them: its sigma of the heading, 104 deg, is right."""


@dataclass(frozen=True)
class Finding:
    """Something about a recording that is wrong, suspicious, or cannot be tested."""

    level: str
    """error, warning or note."""
    code: str
    """no_samples, all_zero, constant, outliers, unit, gravity_removed, bias, strength, scale, axes, sign, gaps, ends_early, saturated, repeated,
    absent, contradiction, clock, damaged, datum, short or not_testable."""
    sensor: str
    """gyro, accel, mag, time or file; position, velocity or speed of the aids."""
    message: str
    """What was found, with its number."""
    argument: str | None = None
    """The argument of hnav.read, or of check, that corrects the fault."""
    value: str = ""
    """The value of that argument."""
    advice: str = ""
    """Another remedy, in words."""
    certain: bool = False
    """Whether the samples allow no other explanation."""

    @property
    def is_meaningless(self) -> bool:
        """Whether the fault must be corrected before an estimate makes sense."""
        return self.certain and self.sensor in MEANINGLESS.get(self.code, ())

    @property
    def stops(self) -> bool:
        """Whether filtering must wait for a correction, or for the hemisphere: without it a negated force cannot be
        distinguished from the other hemisphere."""
        return self.is_meaningless or self.code == "sign"

    @property
    def cure(self) -> str:
        """The remedy as a Python argument."""
        named = ", ".join('"{}": "{}"'.format(*part.split("=")) for part in SEVERAL.split(self.value) if "=" in part)
        value = "True" if self.value == "yes" else f"{{{named}}}" if named else f'"{self.value}"'
        return "; ".join(filter(None, [f"use {self.argument}={value}" if self.argument else "", self.advice]))

    def __str__(self) -> str:
        return f"{self.level}: {self.sensor}: {self.message}" + (f"; {self.cure}" if self.cure else "")


def warning(
    code: str, sensor: str, message: str, argument: str | None = None, value: str = "", advice: str = "", certain: bool = False
) -> Finding:
    """A finding with a remedy."""
    return Finding("warning", code, sensor, message, argument, value, advice, certain)


def unit_name(recording: Recording, quantity: str) -> str:
    """The unit assumed for the numbers of the file."""
    unit = recording.origin.units.get(quantity) if recording.origin else None
    return unit.name if unit else next(iter(SI_PER[quantity]))
