"""A filter run over a recording, with a reference attitude if there is one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.errors import HnavValueError
from hnav.filters.attitude_answers import Run
from hnav.io.recordings import Recording
from hnav.rotations import NED_AND_ENU, quaternion_product

# The start is not compared: the filter begins with one sample of each sensor, the device has converged before.
SETTLING_S = 1.0


@dataclass(frozen=True)
class RecordingRun:
    """A recording, the filter run, and the source of the reference attitude ("" if there is none)."""

    recording: Recording
    result: Run
    reference: str
    filter: str
    findings: tuple[str, ...] = ()  # findings about the recording, a line each

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
        """The reference attitude in the axes of the result; None without one."""
        q_enu = self.recording.reference_q_nb
        if q_enu is None or not self.reference:
            return None
        return q_enu if self.frame == "enu" else quaternion_product(NED_AND_ENU, q_enu)


def recording_run(run: Run, recording: Recording | None = None, findings: Sequence[str] = ()) -> RecordingRun:
    """A run with what it was made of. Raises HnavError when the recording has other rows.

    recording None: nothing is known but the run. The reference attitude of a recording is taken for an optical one.
    """
    if recording is None:
        nothing = np.full((len(run.t_s), 3), np.nan)
        recording = Recording("run", run.t_s, nothing, nothing)
    elif not np.array_equal(recording.t_s, run.t_s):
        raise HnavValueError("size", f"{recording.name}: has other rows than the run; give what the run was made of", "recording")
    filter = "ahrs" if run.options is None else run.options.filter
    return RecordingRun(recording, run, "" if recording.reference_q_nb is None else "optics", filter, tuple(findings))


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


def tilt_sigma_deg(result: Run) -> np.ndarray:
    """Standard deviation of the inclination: both horizontal axes together."""
    return np.asarray(np.degrees(np.hypot(result.sigma_rad[:, 0], result.sigma_rad[:, 1])))
