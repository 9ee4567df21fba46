"""The Hrekf FMU over real recordings: two of commercial IMUs, or the user's own.

    python -m hnav.demo [RECORDING] [--engine fmi3-cs] [--set name=value] [--mag-unit T|uT|G|au] [--out DIR]

Without RECORDING the filter runs over two recordings that hold the device's own attitude (see
hnav.device_recordings), with the default preset and nothing tuned. It prints how far filter and device are apart,
what the filter says about itself, and writes one picture.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from hnav import plots
from hnav.device_recordings import WheelUnavailable, find_wheel, read_x_imu, read_xsens
from hnav.engines import Result, run_recording
from hnav.recordings import Recording, RecordingError, read_recording

# The start is left out of the comparison: the filter has one sample of each sensor there, the device has its past.
SETTLING_S = 1.0
EXPECTED_NIS = 3.0


@dataclass(frozen=True)
class Run:
    """A recording, what the filter made of it, and where the reference attitude is from ("" if there is none)."""

    recording: Recording
    result: Result
    reference: str
    us_per_sample: float


@dataclass(frozen=True)
class Comparison:
    """Differences estimate - reference in deg, after the settling time; series have NaN where there is no reference.

    Total is the angle of the rotation between both; it splits into heading (about the vertical) and inclination
    (about a horizontal axis) as in Laidig et al. 2021, doi 10.3390/data6070072. The heading offset is the circular
    mean of the heading difference: two devices may call different directions north. `heading_deg` is free of it.
    """

    total_deg: np.ndarray
    heading_deg: np.ndarray
    inclination_deg: np.ndarray
    heading_offset_deg: float


def compare(t_s: np.ndarray, q_nb: np.ndarray, reference_q_nb: np.ndarray) -> Comparison:
    """q_nb, reference_q_nb: n x 4, scalar first, body to the same navigation frame."""
    w, x, y, z = _product_with_conjugate(q_nb, reference_q_nb)
    used = (t_s - t_s[0] >= SETTLING_S) & np.isfinite(w)
    heading = np.where(used, 2 * np.arctan2(z, w), np.nan)
    offset = np.angle(np.mean(np.exp(1j * heading[used])))
    return Comparison(
        total_deg=np.degrees(np.where(used, 2 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w)), np.nan)),
        heading_deg=np.degrees(np.angle(np.exp(1j * (heading - offset)))),
        inclination_deg=np.degrees(np.where(used, 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)), np.nan)),
        heading_offset_deg=float(np.degrees(offset)),
    )


def _product_with_conjugate(q: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, ...]:
    """q conj(p), component by component: the rotation in navigation axes that leads from p to q."""
    q0, q1, q2, q3 = q.T
    p0, p1, p2, p3 = p.T
    return (
        q0 * p0 + q1 * p1 + q2 * p2 + q3 * p3,
        -q0 * p1 + q1 * p0 - q2 * p3 + q3 * p2,
        -q0 * p2 + q1 * p3 + q2 * p0 - q3 * p1,
        -q0 * p3 - q1 * p2 + q2 * p1 + q3 * p0,
    )
