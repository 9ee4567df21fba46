"""Faults that recordings have, made on purpose, and what the checks are to say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hnav.io.findings import Finding
from hnav.io.recordings import Recording
from hnav.units import G_M_S2


@dataclass(frozen=True)
class Fault:
    """A fault, and the finding that it must give."""

    make: Callable[[Recording], Recording]
    sensor: str
    code: str
    value: str = ""
    """Of the argument that mends it."""

    def is_named_by(self, finding: Finding) -> bool:
        """Whether a finding says what it is, and the cure."""
        return (finding.sensor, finding.code, finding.value) == (self.sensor, self.code, self.value)


def _gravity_removed(r: Recording) -> Recording:
    """What a telephone calls linear acceleration: what is left above a slow mean."""
    held = np.where(np.isnan(r.force_b_m_s2), np.nanmean(r.force_b_m_s2, axis=0), r.force_b_m_s2)
    width = max(3, round(0.4 / float(np.median(np.diff(r.t_s)))))
    sums = np.cumsum(np.concatenate([held[:1]] * (width // 2) + [held] + [held[-1:]] * (width - width // 2)), axis=0)
    return replace(r, force_b_m_s2=r.force_b_m_s2 - (sums[width:] - sums[:-width]) / width)


def _gap(r: Recording) -> Recording:
    middle = 0.5 * (r.t_s[0] + r.t_s[-1])
    keep = np.abs(r.t_s - middle) > 2.5
    return replace(r, **{name: v[keep] for name, v in vars(r).items() if isinstance(v, np.ndarray)})


def _rows_repeated(r: Recording) -> Recording:
    rows = np.arange(len(r.t_s)) // 2 * 2
    return replace(r, rate_b_rad_s=r.rate_b_rad_s[rows], force_b_m_s2=r.force_b_m_s2[rows])


def _field_held(r: Recording) -> Recording:
    """The last field is repeated in each row until there is a new one, at 5 Hz."""
    t_s, field = r.samples("mag")
    news = np.searchsorted(t_s, np.floor(r.t_s * 5) / 5, side="right") - 1
    return replace(r, field_b_tesla=field[np.clip(news, 0, None)])


def _axis_dead(r: Recording) -> Recording:
    rate = r.rate_b_rad_s.copy()
    rate[:, 1] = np.where(np.isnan(rate[:, 1]), np.nan, 0.0)
    return replace(r, rate_b_rad_s=rate)


SWAPPED = [1, 0, 2]
FAULTS = {
    "force in g": Fault(lambda r: replace(r, force_b_m_s2=r.force_b_m_s2 / G_M_S2), "accel", "unit", "g"),
    "force in mg": Fault(lambda r: replace(r, force_b_m_s2=r.force_b_m_s2 / G_M_S2 * 1e3), "accel", "unit", "mg"),
    "force negated": Fault(lambda r: replace(r, force_b_m_s2=-r.force_b_m_s2), "accel", "sign", "accel=-x,-y,-z"),
    "force negated, no field": Fault(
        lambda r: replace(r, force_b_m_s2=-r.force_b_m_s2, field_b_tesla=None), "accel", "not_testable"
    ),
    "gravity removed": Fault(_gravity_removed, "accel", "gravity_removed"),
    "force axes swapped": Fault(lambda r: replace(r, force_b_m_s2=r.force_b_m_s2[:, SWAPPED]), "accel", "axes", "accel=y,x,z"),
    "field axes swapped": Fault(
        lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla")[:, SWAPPED]), "mag", "axes", "mag=y,x,z"
    ),
    "field z negated": Fault(
        lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * [1, 1, -1]), "mag", "axes", "mag=x,y,-z"
    ),
    "rate axes swapped": Fault(lambda r: replace(r, rate_b_rad_s=r.rate_b_rad_s[:, SWAPPED]), "gyro", "axes", "gyro=y,x,z"),
    "rate negated": Fault(lambda r: replace(r, rate_b_rad_s=-r.rate_b_rad_s), "gyro", "axes", "gyro=-x,-y,-z"),
    "rate in deg/s": Fault(lambda r: replace(r, rate_b_rad_s=np.degrees(r.rate_b_rad_s)), "gyro", "unit", "deg/s"),
    "rate in deg/s, no field": Fault(
        lambda r: replace(r, rate_b_rad_s=np.degrees(r.rate_b_rad_s), field_b_tesla=None), "gyro", "unit", "deg/s"
    ),
    "time in ms": Fault(lambda r: replace(r, t_s=r.t_s * 1e3), "time", "unit", "ms"),
    "time in us": Fault(lambda r: replace(r, t_s=r.t_s * 1e6), "time", "unit", "us"),
    "time in ns": Fault(lambda r: replace(r, t_s=r.t_s * 1e9), "time", "unit", "ns"),
    "half the rate": Fault(lambda r: replace(r, t_s=r.t_s * 2), "gyro", "scale"),
    "field in uT": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * 1e6), "mag", "unit", "uT"),
    "field in G": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * 1e4), "mag", "unit", "G"),
    "field in nT": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * 1e9), "mag", "unit", "nT"),
    "hard iron of 200 uT": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") + [2e-4, 0, 0]), "mag", "strength"),
    "force all zero": Fault(lambda r: replace(r, force_b_m_s2=r.force_b_m_s2 * 0), "accel", "all_zero"),
    "rates missing": Fault(lambda r: replace(r, rate_b_rad_s=r.rate_b_rad_s * np.nan), "gyro", "no_samples"),
    "field all zero": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * 0), "mag", "all_zero"),
    "field stuck": Fault(lambda r: replace(r, field_b_tesla=r.needed("field_b_tesla") * 0 + [2e-5, 0, 4e-5]), "mag", "constant"),
    "an axis of the rates dead": Fault(_axis_dead, "gyro", "constant"),
    "gap of 5 s": Fault(_gap, "gyro", "gaps"),
    "rates clipped": Fault(lambda r: replace(r, rate_b_rad_s=np.clip(r.rate_b_rad_s * 2, -2.2, 2.2)), "gyro", "saturated"),
    "rows repeated": Fault(_rows_repeated, "gyro", "repeated", "yes"),
    "field held": Fault(_field_held, "mag", "repeated", "yes"),
}
