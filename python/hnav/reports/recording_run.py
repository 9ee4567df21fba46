"""What a filter made of a recording, beside another attitude where there is one: figures for a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.errors import HnavValueError
from hnav.filters.attitude import Run
from hnav.filters.rotations import quaternion_product
from hnav.filters.run_summary import NIS_DIMENSIONS
from hnav.fmi.results import Result
from hnav.io.recordings import Recording

# The start is left out of the comparison: the filter has one sample of each sensor there, a device has its past.
SETTLING_S = 1.0
# Turns east-north-up axes into north-east-down ones: half a turn about the bisector of the first two.
TO_NED = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])


@dataclass(frozen=True)
class RecordingRun:
    """A recording, what the filter made of it, and where the reference attitude is from ("" if there is none)."""

    recording: Recording
    result: Result
    reference: str
    filter: str
    findings: tuple[str, ...] = ()  # what was noticed of the recording before the filter saw it, a line each

    @property
    def frame(self) -> str:
        """Of the navigation axes: ned or enu."""
        return "enu" if self.result.options is None else str(self.result.options.navigation_frame)

    @property
    def axes(self) -> tuple[str, str, str]:
        """The names of the navigation axes."""
        return ("north", "east", "down") if self.frame == "ned" else ("east", "north", "up")

    @property
    def reference_q_nb(self) -> np.ndarray | None:
        """The attitude by another system in the axes of the result; None without one."""
        q_enu = self.recording.reference_q_nb
        if q_enu is None or not self.reference:
            return None
        return q_enu if self.frame == "enu" else quaternion_product(np.broadcast_to(TO_NED, q_enu.shape), q_enu)


def recording_run(run: Run, recording: Recording | None = None, findings: Sequence[str] = ()) -> RecordingRun:
    """A run with what it was made of. Raises HnavError when the recording has other rows.

    recording None: nothing is known but the run. The reference attitude of a recording is taken for an optical one.
    """
    if recording is None:
        nothing = np.full((len(run.t_s), 3), np.nan)
        recording = Recording("run", run.t_s, nothing, nothing)
    elif not np.array_equal(recording.t_s, run.t_s):
        raise HnavValueError("size", f"{recording.name}: has other rows than the run; give what the run was made of", "recording")
    result = run if isinstance(run, Result) else Result(**vars(run))
    filter = "ahrs" if run.options is None else run.options.filter
    return RecordingRun(recording, result, "" if recording.reference_q_nb is None else "optics", filter, tuple(findings))


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
    w, x, y, z = quaternion_product(q_nb, reference_q_nb * [1, -1, -1, -1]).T
    used = (t_s - t_s[0] >= SETTLING_S) & np.isfinite(w)
    heading = np.where(used, 2 * np.arctan2(z, w), np.nan)
    offset = np.angle(np.mean(np.exp(1j * heading[used])))
    return Comparison(
        total_deg=np.degrees(np.where(used, 2 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w)), np.nan)),
        heading_deg=np.degrees(np.angle(np.exp(1j * (heading - offset)))),
        inclination_deg=np.degrees(np.where(used, 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z)), np.nan)),
        heading_offset_deg=float(np.degrees(offset)),
    )


def tilt_sigma_deg(result: Result) -> np.ndarray:
    """Standard deviation of the inclination: both horizontal axes together."""
    tilt: np.ndarray = np.degrees(np.hypot(result.sigma_rad[:, 0], result.sigma_rad[:, 1]))
    return tilt


def figures(run: RecordingRun) -> dict[str, str]:
    """The figures of a run as text, by the name of their row."""
    recording, result = run.recording, run.result
    counts = result.counts
    duration_s = recording.t_s[-1] - recording.t_s[0]
    rows = {
        "length, median sample rate": f"{duration_s:.1f} s, {1 / np.median(np.diff(recording.t_s)):.0f} Hz",
        "used rate / force / field": " / ".join(str(counts[f"{sensor}_used"]) for sensor in ("gyro", "accel", "mag")),
        "gated force / field": f"{counts['accel_gated']} / {counts['mag_gated']}",
    }
    if run.reference_q_nb is not None:
        against = compare(recording.t_s, result.q_nb, run.reference_q_nb)
        rows |= {
            f"difference to the {run.reference}": "median    RMS    ",
            "  total": _median_rms(against.total_deg),
            "  heading, offset removed": _median_rms(against.heading_deg),
            "  inclination": _median_rms(against.inclination_deg),
            "  constant heading offset": f"{against.heading_offset_deg:+.1f} deg",
        }
    bias, bias_sigma = np.degrees(result.gyro_bias_rad_s[-1]), np.degrees(result.gyro_bias_sigma_rad_s[-1])
    tilt_deg, heading_deg = tilt_sigma_deg(result)[-1], np.degrees(result.sigma_rad[-1, 2])
    return rows | {
        "the filter about itself": "",
        "  σ tilt, heading at the end": f"{tilt_deg:.1f}, {heading_deg:.1f} deg",
        f"  mean NIS force (expected {NIS_DIMENSIONS[run.filter][0]})": _mean(result.accel_nis),
        f"  mean NIS field (expected {NIS_DIMENSIONS[run.filter][1]})": _mean(result.mag_nis),
        **{f"  gyro bias {axis} ± σ": f"{bias[i]:+.2f} ± {bias_sigma[i]:.2f} deg/s" for i, axis in enumerate("xyz")},
        "time per row": f"{result.us_per_sample:.1f} µs",
    }


def _median_rms(difference_deg: np.ndarray) -> str:
    size = np.abs(difference_deg[np.isfinite(difference_deg)])
    return f"{np.median(size):6.1f} {np.sqrt(np.mean(size**2)):6.1f} deg"


def _mean(nis: np.ndarray) -> str:
    used = nis[np.isfinite(nis)]
    return f"{used.mean():.2g}" if len(used) else "no samples"
