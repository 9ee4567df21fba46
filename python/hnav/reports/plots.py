"""Pictures of attitude estimates: against a reference, against their own sigma, innovations against chi-square bounds.

Every function draws into axes that it is given and touches nothing else; figures are made without pyplot, so no
state is shared and no display is needed. Angles are drawn in degrees, times in seconds. Colours are
those of hnav.reports.colours.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes as Axes
from matplotlib.figure import Figure as Figure

from hnav.errors import HnavValueError
from hnav.filters.filter_answers import HEALTH_SENSORS
from hnav.filters.health import findings, spells
from hnav.io.outputs import write_files
from hnav.reports.angles import euler_deg, near_turn
from hnav.reports.colours import AXIS_COLOURS, BLUE, FAINT, INK, ORANGE, PURPLE, STATE_COLOURS
from hnav.rotations import continuous_quaternion
from hnav.systems.statistics import chi_square_interval

STYLE: dict[Any, Any] = {
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": "#9A9A9A",
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.7,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.3,
    "figure.facecolor": "white",
    # The renderer cannot draw a path of millions of points as one chunk.
    "agg.path.chunksize": 20000,
}
# For pictures of 1200 pixels that a page shows on a telephone, 400 pixels wide.
LARGE_TEXT: dict[Any, Any] = {"font.size": 15, "axes.titlesize": 15, "legend.fontsize": 14}

# The axis of NIS ends here, and its running means take this many windows at most over the whole recording.
NIS_FLOOR, NIS_WINDOWS = 1e-7, 100

# Beyond this pitch roll and yaw are ill-defined; the quaternion is drawn instead.
EULER_PITCH_LIMIT_DEG = 80.0


# --------------------------------------------------------------------------------------------- what is drawn


def running_mean(t_s: np.ndarray, values: np.ndarray, window_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Mean over windows of window_s side by side: their mid times and means (NaN rows left out).

    Windows side by side share no sample, so their means scatter as independent samples would.
    """
    known = np.isfinite(values)
    if not known.any():
        return np.empty(0), np.empty(0)
    t_s, values = t_s[known], values[known]
    window = np.floor((t_s - t_s[0]) / window_s).astype(int)
    count = np.bincount(window)
    used = count > 0
    mean = np.bincount(window, weights=values)[used] / count[used]
    return t_s[0] + (np.flatnonzero(used) + 0.5) * window_s, mean


# --------------------------------------------------------------------------------------------- panels


def styled() -> AbstractContextManager[None]:
    """A context in which figures are made in the look of hnav: `with styled(): ...`; nothing outside changes."""
    return rc_context(STYLE)


class Picture(Figure):
    """A figure that a notebook shows, with pyplot or without."""

    def _repr_png_(self) -> bytes:
        drawn = io.BytesIO()
        self.savefig(drawn, format="png")
        return drawn.getvalue()


def figure(width_px: int, height_px: int, dpi: int = 100) -> Figure:
    """An empty figure of this many pixels."""
    return Picture(figsize=(width_px / dpi, height_px / dpi), dpi=dpi)


def draw_attitude(
    axes: Axes, t_s: np.ndarray, q_nb: np.ndarray, q_ref: np.ndarray | None = None, reference: str = "reference"
) -> str:
    """Attitude of the filter (coloured) over that of a reference (black, dashed); returns what was drawn.

    Roll, pitch and yaw in deg, or the four components of the quaternion when pitch comes near 90 deg, where roll and
    yaw mean nothing. q_nb, q_ref: n x 4, scalar first, body to navigation.
    """
    angles = euler_deg(q_nb)
    as_euler = not np.nanmax(np.abs(angles[:, 1]), initial=0.0) > EULER_PITCH_LIMIT_DEG
    lines = angles if as_euler else continuous_quaternion(q_nb)
    names = ("roll", "pitch", "yaw") if as_euler else ("q0", "q1", "q2", "q3")
    colours = AXIS_COLOURS if as_euler else (PURPLE, *AXIS_COLOURS)
    others = None if q_ref is None else _beside(lines, q_ref, as_euler)
    for column, (name, colour) in enumerate(zip(names, colours)):
        axes.plot(t_s, lines[:, column], color=colour, label=name, lw=1.6)
        if others is not None:
            # Rows without a reference would break the line into invisible points.
            known = np.isfinite(others[:, column])
            label = reference if column == len(names) - 1 else None
            axes.plot(t_s[known], others[known, column], color="black", lw=0.8, ls=(0, (4, 2)), label=label)
    axes.set_ylabel("angle / deg" if as_euler else "quaternion / 1")
    legend_above(axes)
    return "roll, pitch, yaw" if as_euler else "quaternion"


def _beside(lines: np.ndarray, q_ref: np.ndarray, as_euler: bool) -> np.ndarray:
    """The reference as the lines are: angles in the same turn, or quaternions on the same half of the sphere."""
    if as_euler:
        return near_turn(euler_deg(q_ref), lines)
    sign = np.where(np.einsum("ij,ij->i", np.nan_to_num(q_ref), np.nan_to_num(lines)) < 0, -1.0, 1.0)
    return q_ref * sign[:, None]


def draw_error_band(
    axes: Axes,
    t_s: np.ndarray,
    error_deg: np.ndarray,
    sigma_deg: np.ndarray,
    name: str,
    colour: str = BLUE,
    times: float = 3.0,
    one_sided: bool = False,
) -> float:
    """An error (deg) inside the band of +- times sigma that the filter states; returns the share inside, 0 to 1.

    one_sided: the error is a length, the band begins at zero.
    """
    low, label = 0.0 if one_sided else -times * sigma_deg, f"{'' if one_sided else '±'}{times:g}σ stated by the filter"
    axes.fill_between(t_s, low, times * sigma_deg, color=colour, alpha=0.16, lw=0, label=label)
    known = np.isfinite(error_deg)
    axes.plot(t_s[known], error_deg[known], color=colour, lw=1.1, label=name)
    if not one_sided:
        axes.axhline(0.0, color=FAINT, lw=0.7)
    axes.set_ylabel("difference / deg")
    legend_above(axes)
    return float(np.mean(np.abs(error_deg[known]) <= times * sigma_deg[known])) if known.any() else float("nan")


def draw_sigma(axes: Axes, t_s: np.ndarray, sigma_deg: np.ndarray, names: Sequence[str]) -> None:
    """Standard deviations in deg (n x k) on a logarithmic scale."""
    for column, (name, colour) in enumerate(zip(names, AXIS_COLOURS)):
        axes.plot(t_s, sigma_deg[:, column], color=colour, label=name)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.set_ylabel("σ / deg")
    legend_above(axes)


def draw_bias(axes: Axes, t_s: np.ndarray, bias_deg_s: np.ndarray, sigma_deg_s: np.ndarray) -> None:
    """Gyro bias in deg/s (n x 3) with its band of one sigma."""
    for axis, (name, colour) in enumerate(zip("xyz", AXIS_COLOURS)):
        middle, spread = bias_deg_s[:, axis], sigma_deg_s[:, axis]
        axes.fill_between(t_s, middle - spread, middle + spread, color=colour, alpha=0.14, lw=0)
        axes.plot(t_s, middle, color=colour, label=f"{name} ±1σ")
    axes.set_ylabel("gyro bias / (deg/s)")
    legend_above(axes)


def draw_nis(axes: Axes, t_s: np.ndarray, nis: dict[str, np.ndarray], dimension: int = 3, probability: float = 0.95) -> None:
    """Normalised innovations squared by sensor: every sample as a dot, running means as a line.

    The grey band holds a share `probability` of the single samples of a filter whose noise is as parametrised
    (two-sided chi-square, Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2); the dashed line is their mean,
    `dimension`.
    """
    low, high = chi_square_interval(dimension, probability)
    axes.axhspan(low, high, color="#DDDDDD", alpha=0.55, lw=0, label=f"{probability:.0%} of χ²({dimension})")
    axes.axhline(dimension, color=INK, lw=0.9, ls="--", label=f"expected mean {dimension}")
    window_s = max(1.0, (t_s[-1] - t_s[0]) / NIS_WINDOWS)
    floor = low
    for (name, values), colour in zip(nis.items(), (BLUE, ORANGE)):
        shown = np.isfinite(values) & (values > 0)
        axes.plot(t_s[shown], values[shown], ".", color=colour, ms=2.2, alpha=0.3, zorder=2)
        middle_s, mean = running_mean(t_s, values, window_s)
        # A white edge keeps the line readable on its own dots.
        axes.plot(middle_s, mean, color="white", lw=3.2, zorder=3)
        axes.plot(middle_s, mean, color=colour, lw=1.6, zorder=4, label=f"{name}, mean of {window_s:.3g} s")
        if (mean > 0).any():
            floor = min(floor, mean[mean > 0].min())
    axes.set_yscale("log")
    axes.set_ylim(max(10.0 ** np.floor(np.log10(floor)), NIS_FLOOR), 1e2)
    axes.set_ylabel("NIS / 1")
    legend_above(axes)


def draw_health(axes: Axes, t_s: np.ndarray, health: np.ndarray) -> list[str]:
    """A band for each sensor with a finding, drawn where it was not ok; returns the findings, a line each.

    health: n x 3 as Run.health.
    """
    found = findings(t_s, health)
    sensors = list(dict.fromkeys(finding.sensor for finding in found))
    for level, sensor in enumerate(sensors):
        for state, begin, end in spells(t_s, health[:, HEALTH_SENSORS.index(sensor)]):
            # The edge makes a single sample visible.
            axes.broken_barh([(begin, end - begin)], (level - 0.35, 0.7), color=STATE_COLOURS[state], lw=0.6)
    for state in dict.fromkeys(finding.state for finding in found):
        axes.bar(np.nan, 0.0, color=STATE_COLOURS[state], label=state)
    axes.set_yticks(range(len(sensors)), sensors)
    axes.set_ylim(len(sensors) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.set_ylabel("not ok")
    legend_above(axes)
    return [str(finding) for finding in found]


def legend_above(axes: Axes) -> None:
    """The legend in one row at the right above the axes, where it hides no data."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.985), ncols=6, handlelength=1.6, columnspacing=1.1, borderaxespad=0.0)


def save(picture: Figure, path: Path) -> None:
    """Writes the figure as PNG (or what the ending says), making the folder when it is missing. Raises HnavError."""
    kind, known = path.suffix[1:].lower() or "png", picture.canvas.get_supported_filetypes()
    if kind not in known:
        raise HnavValueError(
            "option", f"cannot write {path}: no picture ends in .{kind}; choose one of {', '.join(sorted(known))}"
        )
    drawn = io.BytesIO()
    picture.savefig(drawn, format=kind)
    write_files({path: drawn.getvalue()}, make_folders=True)
