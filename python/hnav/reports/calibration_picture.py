"""The field before and after a calibration: three projections of the ellipsoid and the sphere, and the length."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hnav.filters.calibration import MagnetometerCalibration
from hnav.reports.colours import BLUE, FAINT, INK, ORANGE, VERMILION
from hnav.reports.plots import figure, legend_above, styled

POINTS = 4000  # drawn at most: more points would overlap
WIDE_GAP_RAD = np.radians(30)  # as in the note of the calibration
PLANES = (("x", "y"), ("x", "z"), ("y", "z"))


def silhouette(shape: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Outline (2 x k) of the projection of the ellipsoid centre + shape u, |u| = 1; shape: the two rows that are seen."""
    turn = np.linspace(0, 2 * np.pi, 181)
    # The projection is the ellipse whose matrix is shape shape'.
    return np.asarray(centre[:, None] + np.linalg.cholesky(shape @ shape.T) @ np.stack([np.cos(turn), np.sin(turn)]))


def draw_projection(
    axes: Axes, before: np.ndarray, after: np.ndarray, found: MagnetometerCalibration, plane: tuple[str, str]
) -> None:
    """One pair of axes: measured points around the ellipsoid, corrected points around the sphere, n x 3 each."""
    pair = ["xyz".index(axis) for axis in plane]
    inverse = np.linalg.inv(found.matrix)
    for points, shape, centre, colour, style, name in (
        (before, inverse, found.offset, VERMILION, "--", "measured"),
        (after, np.eye(3), np.zeros(3), BLUE, "-", "corrected"),
    ):
        axes.plot(*points[:, pair].T, ".", color=colour, ms=1.6, alpha=0.35, zorder=2)
        axes.plot(*silhouette(found.strength * shape[pair], centre[pair]), color=colour, ls=style, lw=1.2, zorder=3, label=name)
        axes.plot(*centre[pair], "+", color=colour, ms=9, mew=1.6, zorder=4)
    draw_gap(axes, found, plane)
    axes.axhline(0, color=FAINT, lw=0.6, zorder=1)
    axes.axvline(0, color=FAINT, lw=0.6, zorder=1)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{plane[0]} / {found.unit}")
    axes.set_ylabel(f"{plane[1]} / {found.unit}")
    legend_above(axes)


def draw_gap(axes: Axes, found: MagnetometerCalibration, plane: tuple[str, str]) -> None:
    """The part of the corrected sphere without a sample, seen in the plane, where it is wide enough to do harm."""
    if not found.gap_rad > WIDE_GAP_RAD:
        return
    pair = ["xyz".index(axis) for axis in plane]
    middle = found.gap_direction
    across = np.linalg.svd(middle[None])[2][1:]
    turn = np.linspace(0, 2 * np.pi, 73)
    # Rings of the cap from its centre to its rim: they are visible from any direction.
    for angle in np.linspace(0, found.gap_rad, 12)[1:]:
        rim = np.cos(angle) * middle + np.sin(angle) * (np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1])
        axes.plot(*(found.strength * rim[:, pair]).T, color=ORANGE, lw=0.9, alpha=0.6, zorder=1)
    axes.plot([], [], color=ORANGE, label="no sample")


def draw_length(axes: Axes, before: np.ndarray, after: np.ndarray, found: MagnetometerCalibration) -> None:
    """Histograms of the length of the field in strengths; the axis ends where 99 % of both lie inside."""
    lengths = [np.linalg.norm(points, axis=1) / found.strength for points in (before, after)]
    low, high = np.percentile(np.concatenate(lengths), [0.5, 99.5])
    margin = 0.1 * max(high - low, 1e-6)
    bins = np.linspace(low - margin, high + margin, 80).tolist()
    for values, colour, name in zip(lengths, (VERMILION, BLUE), ("measured", "corrected")):
        axes.hist(values, bins, color=colour, alpha=0.35, density=True)
        axes.hist(values, bins, color=colour, histtype="step", lw=1.3, density=True, label=name)
    axes.axvline(1, color=INK, lw=0.9, ls="--")
    axes.set_xlabel("length / strength")
    axes.set_ylabel("density / 1")
    legend_above(axes)


def draw_calibration(field: np.ndarray, found: MagnetometerCalibration, name: str) -> Figure:
    """The picture of one calibration. field: n x 3 in the unit of the calibration; rows with a NaN are left out."""
    known = field[np.isfinite(field).all(axis=1)]
    shown = known[:: max(1, len(known) // POINTS)]
    with styled():
        picture = figure(1040, 1000)
        grid = picture.subplots(2, 2)
        for axes, plane in zip(grid.flat, PLANES):
            draw_projection(axes, shown, found.apply(shown), found, plane)
            axes.set_title(f"{plane[0]}, {plane[1]}")
        draw_length(grid.flat[3], known, found.apply(known), found)
        grid.flat[3].set_title("Length")
        residual = f"residual {100 * found.residual_before:.2f} % → {100 * found.residual_after:.2f} %"
        picture.suptitle(f"{name}: {found.fit}, {residual}, coverage {found.coverage:.2f}", x=0.06, ha="left", fontweight="bold")
        picture.subplots_adjust(left=0.08, right=0.98, bottom=0.06, top=0.91, wspace=0.2, hspace=0.24)
    return picture
