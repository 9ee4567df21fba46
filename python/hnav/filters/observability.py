"""Which errors samples determine: the share of each variance that they remove, and combinations that they leave as unknown as before.

    found = run.observability()
    found.sentences()                       # heading: only by the field, ...
    found.remaining["heading"], found.t_s   # sigma over that without samples, at the end of each window

A run is divided into windows. Over each of them the linear errors of the filter flow with the estimated attitude, and every kind of sample
adds its information. The recursion is repeated without each kind of sample, which gives those that an error needs, and with the body
held as at the start, which shows whether motion determines it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hnav.native.arrays import Array

UNSEEN = 0.9  # remaining share of a variance above which the samples do not determine the error
SEEN = 0.1  # remaining share of a variance below which the error is determined
FIRST_S = 1.0  # an error that is determined sooner is determined from the start
SLOWER = 2.0  # factor on the time with all samples and the motion above which it takes much longer without them
TURN_RAD = math.radians(10.0)  # least angle of a turn
TURN_SHARE = 0.25  # largest share of the time during which a turn is faster than half its peak
_PART = 0.2  # share of the largest component above which another one is part of a combination
_SINGULAR = 1e-9  # share of the largest variance below which a direction is singular


@dataclass(frozen=True)
class Removed:
    """The reduction of the variances by the samples."""

    share: dict[str, float]
    """By name: 1 - variance with the samples / variance without them. 0: they determine nothing of it."""
    unseen: tuple[tuple[str, ...], ...]
    """Combinations of which they remove less than a tenth of the variance, by the names that take part."""


def removed(names: Sequence[str], prior: Array, left: Array) -> Removed:
    """From the covariances without samples and with them."""
    scale = np.sqrt(np.diag(prior))
    known = scale > 0
    share = {name: float(1 - left[i, i] / prior[i, i]) if known[i] else math.nan for i, name in enumerate(names)}
    among = [name for name, is_known in zip(names, known) if is_known]
    per = np.outer(scale[known], scale[known])
    before, after = prior[np.ix_(known, known)] / per, left[np.ix_(known, known)] / per
    values, vectors = np.linalg.eigh(before)
    independent = values > _SINGULAR * values.max(initial=0.0)
    root = vectors[:, independent] * np.sqrt(values[independent])
    whitener = vectors[:, independent] / np.sqrt(values[independent])
    remains, directions = np.linalg.eigh(whitener.T @ after @ whitener)
    unseen = _sparse(root @ directions[:, remains > UNSEEN])
    return Removed(share, tuple(tuple(name for name, size in zip(among, row) if size > _PART) for row in unseen))


def _sparse(basis: Array) -> list[Array]:
    """Sizes of the components, at most 1, of directions that span the same as the columns, each with as many zeros as elimination gives."""
    rows = basis.T.copy()
    for used in range(len(rows)):
        left = np.abs(rows[used:])
        row, column = divmod(int(np.argmax(left)), left.shape[1])
        rows[[used, used + row]] = rows[[used + row, used]]
        rows[used] /= rows[used, column]
        for other in range(len(rows)):
            if other != used:
                rows[other] -= rows[other, column] * rows[used]
    return [np.abs(row) / np.abs(row).max() for row in rows]


# --------------------------------------------------------------------------------------------- errors over windows


@dataclass(frozen=True)
class Windows:
    """The errors of a filter over m windows; every error is in units of its standard deviation without samples."""

    t_s: Array
    """m: ends, from the first row of the run on."""
    begin_s: float
    """Begin of the first window: the time of the first attitude."""
    Phi: Array
    """m x n x n: transition over each window."""
    Q: Array
    """m x n x n: covariance that noise adds in each window."""
    information: dict[str, Array]
    """m x n x n: information of the samples of each kind about the errors at the end of each window."""


@dataclass(frozen=True)
class RunObservability:
    """Which errors of attitude and biases the samples of a run determine, by what, and from when on."""

    t_s: Array
    """m: ends of the windows, from the first row of the run on."""
    begin_s: float
    """Of the first window: from the first attitude on."""
    remaining: dict[str, Array]
    """By error, m: standard deviation with the samples over that without any, at most 1."""
    needs: dict[str, tuple[str, ...]]
    """By error that is determined: the kinds of samples without any of which it is not."""
    by_motion: dict[str, float]
    """By error that a body at rest would not determine, or much later: when the turn that determines it was fastest, s; NaN where no turn did."""
    later_without: dict[str, dict[str, float]]
    """By error: kinds of samples without which it is determined much later, and when, s."""
    unseen: tuple[tuple[str, ...], ...]
    """Combinations of which the samples remove less than a tenth of the variance."""

    def determined_s(self, name: str) -> float:
        """From when on an error is determined: less than a tenth of its variance is left; infinite for never."""
        return _from_when(self.t_s, self.begin_s, self.remaining[name] ** 2)

    def sentences(self) -> list[str]:
        """A line for each group of errors of which the same can be said, and one for each combination that is not observable."""
        said: dict[str, list[str]] = {}
        for name in self.remaining:
            said.setdefault(self._when(name), []).append(name)
        lines = [f"{joined(names)}: {words}" for words, names in said.items()]
        return lines + [f"only a combination: {joined(names)}" for names in self.unseen if len(names) > 1]

    def _when(self, name: str) -> str:
        at_s = self.determined_s(name)
        if np.isinf(at_s):
            left = self.remaining[name][-1]
            return "not observable" if left**2 > UNSEEN else f"in part: sigma falls to {100 * left:.2g} %"
        needs = self.needs[name]
        by = f"only by {joined(needs, 'the ')}{' together' * (len(needs) > 1)}, " if needs else ""
        later = [f"; without the {kind} after {later_s:.3g} s" for kind, later_s in self.later_without[name].items()]
        return by + self._from(name, at_s) + "".join(later)

    def _from(self, name: str, at_s: float) -> str:
        if at_s - self.begin_s <= FIRST_S:
            return "from the start"
        turn_s = self.by_motion.get(name)
        if turn_s is None:
            return f"after {at_s:.3g} s"
        return f"by the motion, after {at_s:.3g} s" if np.isnan(turn_s) else f"after the turn at {turn_s:.3g} s"


def run_observability(windows: Windows, at_rest: Windows, names: Sequence[str], turned_rad: Array) -> RunObservability:
    """windows: of a run; at_rest: the same with the body held as at the start. names: of the first errors, which are shown.

    turned_rad: m, by how much the body turns in each window.
    """
    kinds = [kind for kind, information in windows.information.items() if information.any()]
    every = [(windows, [k for k in kinds if k != left_out]) for left_out in (None, *kinds)]
    shown = len(names)
    variances, last = _recursions([*every, (at_rest, kinds)], shown)
    t_s, begin_s = windows.t_s, windows.begin_s
    when = np.array([[_from_when(t_s, begin_s, v[:, i]) for i in range(shown)] for v in variances])
    found = RunObservability(t_s, begin_s, {}, {}, {}, {}, removed(names, np.eye(shown), last).unseen)
    for i, name in enumerate(names):
        at_s, without, still_s = when[0, i], when[1:-1, i], when[-1, i]
        late = begin_s + max(SLOWER * (at_s - begin_s), FIRST_S)
        found.remaining[name] = np.sqrt(np.minimum(1.0, variances[0][:, i]))
        if np.isinf(at_s):
            continue
        found.needs[name] = tuple(kind for kind, s in zip(kinds, without) if np.isinf(s))
        found.later_without[name] = {kind: float(s) for kind, s in zip(kinds, without) if late < s < np.inf}
        if still_s > late:
            found.by_motion[name] = _turn_s(t_s, begin_s, turned_rad, at_s)
    return found


def _recursions(cases: Sequence[tuple[Windows, Sequence[str]]], shown: int) -> tuple[list[Array], Array]:
    """For windows and kinds of samples: variances of the first errors at the end of each window; and the last covariance of the first."""
    first = cases[0][0]
    m, n = first.Phi.shape[:2]
    Phi, Q = (np.stack([getattr(windows, name) for windows, _ in cases], axis=1) for name in ("Phi", "Q"))
    nothing = np.zeros((m, n, n))
    information = np.stack([sum((w.information[kind] for kind in kinds), nothing) for w, kinds in cases], axis=1)
    P = np.broadcast_to(np.eye(n), (len(cases), n, n))
    kept = np.empty((m, len(cases), shown))
    for k in range(m):
        P = Phi[k] @ P @ np.swapaxes(Phi[k], 1, 2) + Q[k]
        P = np.linalg.solve(np.eye(n) + P @ information[k], P)
        P = 0.5 * (P + np.swapaxes(P, 1, 2))
        kept[k] = np.diagonal(P, axis1=1, axis2=2)[:, :shown]
    return list(np.moveaxis(kept, 1, 0)), P[0][:shown, :shown]


def _from_when(t_s: Array, begin_s: float, variance: Array) -> float:
    """The time from which an error is determined to the end; infinite for never."""
    known = variance <= SEEN
    if not len(known) or not known[-1]:
        return np.inf
    unknown = np.flatnonzero(~known)
    first = 0 if not len(unknown) else unknown[-1] + 1
    return float(t_s[first]) if first else begin_s


def _turn_s(t_s: Array, begin_s: float, turned_rad: Array, at_s: float) -> float:
    """When the body turned fastest in the time before; NaN where it hardly turned, or turned all the time."""
    before = t_s <= at_s + FIRST_S
    lengths = np.diff(t_s, prepend=begin_s)[before]
    rates = turned_rad[before] / lengths
    turning = rates > 0.5 * np.max(rates, initial=0.0)
    if turned_rad[before].sum() < TURN_RAD or lengths[turning].sum() > TURN_SHARE * (at_s - begin_s):
        return np.nan
    return float(t_s[before][np.argmax(rates)])


def joined(names: Sequence[str], article: str = "") -> str:
    """a, b and c; the article stands before each of them."""
    each = [article + name for name in names]
    return each[0] if len(each) == 1 else f"{', '.join(each[:-1])} and {each[-1]}"
