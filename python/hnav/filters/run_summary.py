"""The figures of a run: last attitude and bias with sigma, times of readiness, sample rates, innovations.

for name, value in rows(summary(run)): print(name, value)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

import numpy as np

from hnav.filters.attitude_answers import Run
from hnav.filters.readiness import sigmas, smallest, why_never
from hnav.native.arrays import Array

NAMES = ("tilt", "heading")
NIS_DIMENSIONS = {"hrekf": (3, 3), "ahrs": (2, 3)}
"""What the mean NIS of force and field is expected to be, by filter."""


@dataclass(frozen=True)
class Summary:
    """Angles in deg, rates in deg/s, times in s; NaN where a figure is undefined."""

    rows: int
    """Rows of the run."""
    length_s: float
    """From the first row to the last."""
    last_s: float
    """Time of the last row with an attitude."""
    euler_deg: Array
    """3: roll, pitch, yaw in that row."""
    heading_deg: float
    """Heading in that row, 0 to 360."""
    tilt_sigma_deg: float
    """Standard deviation of the tilt in that row, both horizontal axes together."""
    heading_sigma_deg: float
    """Standard deviation of the heading in that row."""
    bias_deg_s: Array
    """3, body axes: gyro bias in that row."""
    bias_sigma_deg_s: Array
    """3: standard deviation of that bias."""
    ready_s: Array
    """2: time from the first row until the tilt, and the heading, were first ready."""
    never: Mapping[str, str]
    """Of tilt and heading, if it was never ready: why."""
    ready_share: Array
    """2: share of the rows in which tilt, and heading, were ready."""
    nis: Array
    """2: mean normalised innovation squared of force and field."""
    accepted_share: Array
    """2: share of the used samples of force and field that their gates let pass as they were."""


def summary(run: Run) -> Summary:
    """The figures of a run."""
    n, known = len(run.t_s), np.flatnonzero(np.isfinite(run.q_nb).all(axis=1))
    last = known[-1] if len(known) else None

    def there(values: Array) -> Array:
        return np.full(values.shape[1:], np.nan) if last is None else np.degrees(values[last])

    sigma = there(run.sigma_rad)
    nis = np.stack([run.accel_nis, run.mag_nis], axis=1)
    used = np.isfinite(nis)
    return Summary(
        rows=n, length_s=float(run.t_s[-1] - run.t_s[0]) if n else 0.0,
        last_s=np.nan if last is None else float(run.t_s[last]),
        euler_deg=there(run.euler_rad), heading_deg=float(there(run.heading_rad)) % 360,
        tilt_sigma_deg=float(np.hypot(sigma[0], sigma[1])), heading_sigma_deg=float(sigma[2]),
        bias_deg_s=there(run.gyro_bias_rad_s), bias_sigma_deg_s=there(run.gyro_bias_sigma_rad_s),
        ready_s=np.array([run.t_s[rows[0]] - run.t_s[0] if len(rows) else np.nan for rows in map(np.flatnonzero, run.ready.T)]),
        never=_never(run),
        ready_share=_shares(run.ready, np.full((n, 2), True)),
        nis=np.array([np.mean(values[of]) if of.any() else np.nan for values, of in zip(nis.T, used.T)]),
        accepted_share=np.full(2, np.nan) if run.accepted is None else _shares(run.accepted, used),
    )  # fmt: skip


def _never(run: Run) -> dict[str, str]:
    """Why tilt and heading were never ready, if they were not."""
    of_each = zip(NAMES, smallest(sigmas(run.sigma_rad)), run.ready.T)
    return {name: why_never(name, float(sigma), run.options) for name, sigma, flags in of_each if not flags.any()}


def _shares(marked: np.ndarray, among: np.ndarray) -> Array:
    """Of the rows among which there are marked ones, column by column."""
    count = among.sum(axis=0)
    return np.where(count > 0, (marked & among).sum(axis=0) / np.maximum(count, 1), np.nan)


def rows(found: Summary) -> list[tuple[str, str]]:
    """Name and value of each figure that is known, as text."""
    roll, pitch, _ = found.euler_deg
    said = {
        "length": f"{found.length_s:.6g} s, {found.rows} rows",
        "last attitude at": f"{found.last_s:.15g} s",
        "roll, pitch": f"{roll:.2f}, {pitch:.2f} deg, sigma of tilt {found.tilt_sigma_deg:.2f} deg",
        "heading": f"{found.heading_deg:.2f} deg, sigma {found.heading_sigma_deg:.2f} deg",
        "gyro bias x, y, z": f"{_three(found.bias_deg_s)} deg/s",
        "its sigma": f"{_three(found.bias_sigma_deg_s)} deg/s",
    }
    if np.isnan(found.last_s):
        said = {"length": said["length"], "attitude": "none: the filter did not start"}
    for i, name in enumerate(NAMES):
        share = 100 * found.ready_share[i]
        ready = f"after {found.ready_s[i]:.3g} s, in {share:.3g} % of the rows"
        said[f"{name} ready"] = ready if name not in found.never else f"never: {found.never[name]}"
    for i, name in enumerate(("force", "field")):
        if np.isfinite(found.nis[i]):
            passed = found.accepted_share[i]
            gate = f"; its gate let {100 * passed:.4g} % pass" if np.isfinite(passed) else ""
            said[f"mean NIS of the {name}"] = f"{found.nis[i]:.3g}{gate}"
    return list(said.items())


def in_one_line(run: Run) -> str:
    """A run in a line: rows, rate, last attitude."""
    found = summary(run)
    size = f"{found.rows} rows in {found.length_s:.6g} s"
    if np.isnan(found.last_s):
        return f"{size}, no attitude"
    roll, pitch, _ = found.euler_deg
    ready = [name for name, share in zip(NAMES, found.ready_share) if share > 0]
    return f"{size}, last roll {roll:.1f}, pitch {pitch:.1f}, heading {found.heading_deg:.1f} deg, ready: {', '.join(ready) or 'nothing'}"


def as_html(run: Run) -> str:
    """A run as a small table."""
    options = "" if run.options is None else f" by {escape(repr(run.options))}"
    left = '<td style="text-align:left">'
    cells = "".join(f"<tr>{left}{escape(name)}</td>{left}{escape(value)}</td></tr>" for name, value in rows(summary(run)))
    return f"<table><caption>Run{options}</caption>{cells}</table>"


def _three(values: Array) -> str:
    return ", ".join(f"{value:.4f}" for value in values)
