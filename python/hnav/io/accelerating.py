"""Whether force and rates follow the velocities of satellites, whatever moves.

Seen from axes that the rates hold still, the integral of the force is the change of the velocity less that by gravity, but for one
rotation in each window (Wahba's problem). With exchanged or negated axes it is not. Bodies need not point along their course for this.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hnav.io.aids import AidSamples
from hnav.io.turning import HANDED, IDENTITY, PARTS, STAY_S, WAYS, Samples, axes_text, held_force
from hnav.units import G_M_S2

PART_S = STAY_S / PARTS
FEWEST_WINDOWS, MOST_WINDOWS = 4, 100
LONGEST_GAP_S, LONGEST_STEP_S = 2.5, 0.3
"""Between velocities, and between rates, in a window."""
LAGS_S = (-0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0)
"""Delays of the velocities that are tried: late stamps are no wrong axes."""
FITS_M_S = 1.5
"""RMS error over PART_S, from receiver noise and vibration, up to which an assignment explains the velocities. With wrong units or a
dead axis no assignment does."""
WORSE = 1.8
"""Ratio of the mean squared errors from which the axes as they are count as wrong; simulated vehicles with right axes reach 1.6."""
AS_GOOD = 1.1
"""Ratio up to which two assignments count as equal."""
LARGEST_BIAS_RAD_S, BIASES_TRIED = 0.09, 40
"""5 deg/s, four times that of a chip that was never calibrated; the search stops after so many."""


@dataclass(frozen=True)
class Following:
    """How well each assignment of axes explains the velocities."""

    error: np.ndarray
    """2 x 48: RMS error in m/s over PART_S; rates as they are and negated, force by each of WAYS."""

    @property
    def ratio(self) -> float:
        """Mean squared error of the axes as they are to that of the best assignment."""
        return float((self.error[0, IDENTITY] / self.error.min()) ** 2)

    @property
    def off(self) -> bool:
        """Whether another assignment explains the velocities, and this one does not."""
        return self.ratio > WORSE and float(self.error.min()) < FITS_M_S

    @property
    def axes(self) -> dict[str, str] | None:
        """The axes of gyro and accel that explain the velocities, of those that have to change; None where several explain them alike."""
        alike = np.argwhere(self.error**2 <= AS_GOOD * self.error.min() ** 2)
        if len(alike) > 1:
            return None
        negated, way = int(alike[0, 0]), int(alike[0, 1])
        if negated and HANDED[way] > 0:
            return {"gyro": axes_text(-WAYS[way].T)}
        if not negated:
            return {"accel": axes_text(WAYS[way])}
        mirror = np.diag([1.0, -1.0, 1.0])  # any axis of both may be the wrong one: z, which is up or down in most bodies, stays
        return {"gyro": axes_text(mirror), "accel": axes_text(-mirror @ WAYS[way])}


def following_of(gyro: Samples, force: Samples, velocity: AidSamples) -> Following | None:
    """The fit of all assignments; None for too few windows with velocities. velocity: in order of time, vertical part perhaps NaN."""
    held = held_force(gyro, force)
    mirrored = held_force((gyro[0], -gyro[1]), force)
    if held is None or mirrored is None:
        return None
    edges_s = held[0]
    kept = np.flatnonzero(_whole(edges_s, gyro[0], velocity.t_s))
    if len(kept) < FEWEST_WINDOWS:
        return None
    spread = _changes(edges_s[kept], velocity).std(axis=1).sum(axis=1)
    kept = kept[np.argsort(-spread)[:MOST_WINDOWS]]
    changes = np.stack([_changes(edges_s[kept] + lag_s, velocity) for lag_s in LAGS_S])
    following = Following(np.stack([_errors(one[kept], changes, WAYS) for one in (held[1], mirrored[1])]))
    if following.off:  # a bias that tilts the axes, which other axes would not, is no wrong axis
        following.error[0, IDENTITY] = _error_without_bias(gyro, force, kept, changes)
    return following


def _error_without_bias(gyro: Samples, force: Samples, kept: np.ndarray, changes: np.ndarray) -> float:
    """Error of the axes as they are, with the constant bias of the rates that makes it least."""
    from scipy.optimize import minimize  # takes longer to load than --help may

    def error(bias_rad_s: np.ndarray) -> float:
        held = held_force((gyro[0], gyro[1] - bias_rad_s), force)
        assert held is not None, "as long as without a bias"
        return float(_errors(held[1][kept], changes, np.eye(3)[None])[0])

    start = np.vstack([np.zeros(3), LARGEST_BIAS_RAD_S * np.eye(3)])
    found = minimize(error, np.zeros(3), method="Nelder-Mead", options={"initial_simplex": start, "maxfev": BIASES_TRIED})
    return float(found.fun)


def _whole(edges_s: np.ndarray, *clocks_s: np.ndarray) -> np.ndarray:
    """Which windows lie within the times of rates and velocities, whatever the delay, without a gap in either."""
    begin_s, end_s = edges_s[:, 0] + min(LAGS_S), edges_s[:, -1] + max(LAGS_S)
    whole = np.ones(len(edges_s), bool)
    rates_s, fixes_s = clocks_s
    whole &= (begin_s >= fixes_s[0]) & (end_s <= fixes_s[-1])
    for clock_s, longest_s in ((rates_s, LONGEST_STEP_S), (fixes_s, LONGEST_GAP_S)):
        for at in np.flatnonzero(np.diff(clock_s) > longest_s):
            whole &= (end_s <= clock_s[at]) | (begin_s >= clock_s[at + 1])
    return whole


def _changes(edges_s: np.ndarray, velocity: AidSamples) -> np.ndarray:
    """k x parts x 3: changes of the velocity less those by gravity, in m/s, north, east, down."""
    at = np.stack([np.interp(edges_s, velocity.t_s, column) for column in np.nan_to_num(velocity.values).T], axis=-1)
    return np.asarray(np.diff(at, axis=1) - [0, 0, G_M_S2 * PART_S])


def _errors(impulses: np.ndarray, changes: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """w: RMS error of a part, with the best delay. impulses: k x parts x 3 x 3 x 3; changes: delays x k x parts x 3; ways: w x 3 x 3."""
    turned = np.einsum("kpabc,wbc->wkpa", impulses, ways)
    both = np.einsum("wkpa,lkpb->lwkab", turned, changes)
    values = np.linalg.svd(both, compute_uv=False)
    agreed = values[..., 0] + values[..., 1] + np.sign(np.linalg.det(both)) * values[..., 2]
    squared = (turned**2).sum(axis=(2, 3)) + (changes**2).sum(axis=(2, 3))[:, None] - 2 * agreed
    return np.asarray(np.sqrt(np.maximum(squared.mean(axis=2), 0).min(axis=0) / PARTS))
