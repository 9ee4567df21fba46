"""Statistics of samples and runs: means with their intervals, ratios of means, and the bounds of chi-square.

Intervals of means are Student's t over the runs, which are independent; the ratio of two filters over the same runs is
bootstrapped over the runs, pair by pair.
"""

from __future__ import annotations

import numpy as np
from scipy import special

CONFIDENCE = 0.95
BOOTSTRAP_DRAWS, BOOTSTRAP_SEED = 2000, 1


def normalised_squares(error: np.ndarray, P: np.ndarray) -> np.ndarray:
    """e' P^-1 e of each error (... x n), P its covariance (... x n x n)."""
    return np.asarray(np.einsum("...i,...i->...", error, np.linalg.solve(P, error[..., None])[..., 0]))


def finite_mean(values: np.ndarray) -> float:
    """Mean of the finite values; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan


def mean_interval(values: np.ndarray, confidence: float = CONFIDENCE) -> tuple[float, float, float]:
    """Mean and its two-sided Student interval over the finite values; NaN ends for fewer than two."""
    known = np.asarray(values, float)
    known = known[np.isfinite(known)]
    if len(known) < 2:
        return (float(known.mean()) if len(known) else np.nan), np.nan, np.nan
    half = special.stdtrit(len(known) - 1, (1 + confidence) / 2) * known.std(ddof=1) / np.sqrt(len(known))
    return float(known.mean()), float(known.mean() - half), float(known.mean() + half)


def ratio_interval(numerator: np.ndarray, denominator: np.ndarray, confidence: float = CONFIDENCE) -> tuple[float, float, float]:
    """Ratio of two means over the same runs and its percentile bootstrap interval (Efron and Tibshirani 1993, ch. 13).

    Runs are drawn as pairs, for both filters have seen the same noise; the draws are seeded.
    """
    pairs = np.column_stack([numerator, denominator]).astype(float)
    pairs = pairs[np.isfinite(pairs).all(axis=1)]
    if len(pairs) < 2:
        return np.nan, np.nan, np.nan
    drawn = np.random.default_rng(BOOTSTRAP_SEED).integers(0, len(pairs), (BOOTSTRAP_DRAWS, len(pairs)))
    means = pairs[drawn].mean(axis=1)
    low, high = np.quantile(means[:, 0] / means[:, 1], [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(pairs[:, 0].mean() / pairs[:, 1].mean()), float(low), float(high)


def chi_square_interval(dimension: int, probability: float = 0.95) -> tuple[float, float]:
    """Two-sided bounds of the sum of `dimension` squared standard normal numbers with this probability."""
    low, high = (float(special.chdtri(dimension, 1 - share)) for share in ((1 - probability) / 2, (1 + probability) / 2))
    return low, high


def nees_bounds(runs: int, probability: float = 0.999, dimension: int = 3) -> tuple[float, float]:
    """Two-sided bounds of the mean NEES of a consistent filter over independent runs: chi-square(runs dimension) / runs
    (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2).
    """
    low, high = chi_square_interval(runs * dimension, probability)
    return low / runs, high / runs
