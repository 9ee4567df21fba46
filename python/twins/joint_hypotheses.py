"""The joint hypotheses of the filter for coloured INS errors again in NumPy: the law of c_src/ins_error/joint_hypotheses.hpp, with
an inverse of its own for each innovation given the others."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from hnav.filters.ins_error import InsErrorOptions
from hnav.native.arrays import Array

# Hypotheses about the process, with factors on Q and Ql; the first is the stated process.
MOTION = np.array([1.0, 10.0, 1.0])
COLOUR = np.array([1.0, 2.0, 20.0])
PROCESS_DRIFT, NOISE_DRIFT = 5e-4, 0.01
COMMON_SHARE = 0.8
BIAS_CERTAIN, BIAS_FADING = 0.9, 0.07
SWEEP_FROM = 0.05  # odds against the stated process below which an increased one takes its modes


@dataclass
class Prior:
    """Priors of one channel, by mode: of the lasting modes (noise levels, then bias) and of the outliers of one sample."""

    lasting: Array
    outlier: Array

    @property
    def all(self) -> Array:
        both: Array = self.lasting + self.outlier
        return both


@dataclass
class Sweep:
    """Result of the tests of all channels under one hypothesis about the process."""

    log_evidence: float
    by_modes: float
    """The part of it that the modes add to the evidence of a normal distribution."""
    likelihood: Array
    """Likelihoods by channel and mode."""
    innovation: Array
    """Innovation of each channel given all others."""
    variance: Array
    """Its variance in a healthy channel."""


class JointHypotheses:
    """scale, noise, bias: by channel; process: a number; motion, colour: factors on Q and Ql; opened: variances for lambda."""

    def __init__(self, options: InsErrorOptions, nz: int):
        self.o = o = options
        n = o.hmm_levels
        self.levels = o.hmm_level_ratio ** np.arange(n)
        self.precision = np.append(1 / self.levels, 0)  # a measurement with an unknown bias carries no information
        self.least_precision = min(1e-4, 1 / self.levels[-1])
        self.scale, self.noise, self.bias, self.process = np.ones(nz), np.zeros(nz), np.zeros(nz), 0.0
        self.belief = np.tile(np.eye(n + 1)[0], (nz, 1))
        self.process_belief = np.eye(len(MOTION))[0]
        self.tracked, self.tracked_variance = np.zeros(nz), np.zeros(nz)
        self.motion, self.colour, self.opened = 1.0, 1.0, np.zeros(nz)
        self.outlier_levels = np.arange(n + 1)[min(2, n - 1) : n]
        self.transition = self._chain(o.joint_fault_probability)
        self.common_transition = self._chain(COMMON_SHARE)
        k = len(MOTION)
        T = np.full((k, k), PROCESS_DRIFT / (k - 1))
        T[0], T[:, 0] = o.joint_process_probability / (k - 1), o.joint_process_recovery_probability
        np.fill_diagonal(T, 0)
        self.process_transition = T + np.diag(1 - T.sum(axis=1))

    def _chain(self, fault: float) -> Array:
        """Transitions of the lasting modes; the probability of an outlier is missing in the row of the healthy one."""
        o, n = self.o, self.o.hmm_levels
        T = np.zeros((n + 1, n + 1))
        T[0, 1:n], T[0, n] = fault / (n - 1), o.joint_bias_probability
        T[0, 0] = 1 - fault - o.joint_bias_probability - o.joint_outlier_probability
        for g in range(1, n):
            neighbours = [h for h in (g - 1, g + 1) if 1 <= h < n]
            T[g, neighbours] = NOISE_DRIFT / max(1, len(neighbours))
            T[g, 0] = o.joint_recovery_probability
            T[g, g] = 1 - T[g].sum()
        T[n, 0], T[n, n] = BIAS_FADING, 1 - BIAS_FADING
        return T

    def _priors(self, transition: Array) -> list[Prior]:
        outlier = np.zeros(self.belief.shape)
        share = self.o.joint_outlier_probability / len(self.outlier_levels)
        outlier[:, self.outlier_levels] = share * self.belief[:, :1]
        return [Prior(*rows) for rows in zip(self.belief @ transition, outlier)]

    def _predict_bias(self, priors: list[Prior], fresh: Array, wanders: Array) -> None:
        """The tracked constant is the previous one, a random walk with the variance of the prediction, or begins now."""
        for i, prior in enumerate(priors):
            if not fresh[i] > 0:
                continue
            share = self.belief[i, -1] * (1 - BIAS_FADING) / prior.lasting[-1] if prior.lasting[-1] > 0 else 0.0
            jump = self.o.joint_bias_sigma**2 * fresh[i]
            mean = share * self.tracked[i]
            spread = self.tracked_variance[i] + wanders[i] + (self.tracked[i] - mean) ** 2
            self.tracked_variance[i] = share * spread + (1 - share) * (jump + mean**2)
            self.tracked[i] = mean

    def update(self, nu: Array, base: Array, fresh: Array, motion: Array, colour: Array, driven: bool) -> None:
        """nu: NaN where missing; base: S without white noise; fresh: Qv_ii; motion: H Q H'; colour: Ql; driven: not the first."""
        judged = [int(i) for i in np.flatnonzero(~np.isnan(nu) & (fresh > 0))]
        priors, common = self._priors(self.transition), self._priors(self.common_transition)
        self._predict_bias(priors, fresh, driven * np.diag(motion + colour))
        start = np.array([1 / max(prior.all @ self.precision, self.least_precision) for prior in priors])
        # The channel that its own variance explains least comes first.
        judged.sort(key=lambda i: -(nu[i] ** 2) / (base[i, i] + fresh[i] * start[i]))
        if driven:
            self.process_belief = self.process_belief @ self.process_transition
        swept = [self._sweep(nu, base, fresh, start, priors, judged)]
        for x, c, prior in list(zip(MOTION, COLOUR, self.process_belief))[1:] if driven else []:
            process = base + (x - 1) * motion + (c - 1) * colour
            alike = replace(swept[0], log_evidence=_normal_evidence(nu, process, fresh * start) + swept[0].by_modes)
            odds = prior * np.exp(alike.log_evidence - swept[0].log_evidence) / self.process_belief[0]
            swept.append(self._sweep(nu, process, fresh, start, priors, judged) if odds > SWEEP_FROM else alike)
        likelihood = swept[0].likelihood
        ratio = sum(np.log((common[i].all @ likelihood[i]) / (priors[i].all @ likelihood[i])) for i in judged)
        evidence = np.array([*(each.log_evidence for each in swept), swept[0].log_evidence + ratio])
        weight = self._merge(evidence if np.isfinite(nu).any() else 0 * evidence)

        self.bias = self.bias * (1 - BIAS_FADING)
        self.opened[:] = 0
        for i in map(int, np.flatnonzero(fresh > 0)):
            if i in judged:
                self._merge_channel(i, weight, [*[priors[i]] * len(swept), common[i]], [*swept, swept[0]])
                self._open_if_certain(i, fresh[i])
            else:
                self.belief[i], self.scale[i] = priors[i].lasting, start[i]
                self.belief[i, 0] += priors[i].outlier.sum()
            self.noise[i] = self.belief[i, 1:-1].sum()

    def _merge(self, evidence: Array) -> Array:
        """Probabilities of the processes that were swept and, last, of common noise, which begins under the stated process."""
        count = len(evidence) - 1
        prior = np.append(self.process_belief[:count], self.process_belief[0] * self.o.joint_common_probability)
        prior[0] *= 1 - self.o.joint_common_probability
        weight: Array = prior * np.exp(evidence - np.max(evidence))
        weight /= weight.sum() + self.process_belief[count:].sum()
        self.motion = float(weight[:-1] @ np.sqrt(MOTION[:count]) + weight[-1]) ** 2
        self.colour = float(weight[:-1] @ np.sqrt(COLOUR[:count]) + weight[-1]) ** 2
        self.process_belief[:count] = weight[:-1]
        self.process_belief[0] += weight[-1]
        self.process = float(self.process_belief[1:].sum())
        return weight

    def _merge_channel(self, i: int, weight: Array, priors: list[Prior], swept: list[Sweep]) -> None:
        """Modes, noise and tracked constant of a channel over all hypotheses."""
        now, precision = np.zeros(self.belief.shape[1]), 0.0
        for w, prior, each in zip(weight, priors, swept):
            found = each.likelihood[i]
            lasting, passing = (part * found / (prior.all @ found) for part in (prior.lasting, prior.outlier))
            now += w * lasting
            now[0] += w * passing.sum()
            precision += w * (lasting + passing) @ self.precision
        self.belief[i], self.scale[i] = now, 1 / max(precision, self.least_precision)
        r = sum(w * each.innovation[i] for w, each in zip(weight, swept))
        variance = sum(w * each.variance[i] for w, each in zip(weight, swept))
        gain = self.tracked_variance[i] / (self.tracked_variance[i] + variance)
        self.tracked[i] += gain * (r - self.tracked[i])
        self.tracked_variance[i] *= 1 - gain

    def _open_if_certain(self, i: int, fresh: float) -> None:
        self.bias[i] = max(self.bias[i], self.belief[i, -1])
        if self.belief[i, -1] > BIAS_CERTAIN:
            self.opened[i] = self.o.joint_bias_sigma**2 * fresh
            self.belief[i], self.scale[i], self.bias[i] = np.eye(self.belief.shape[1])[0], 1.0, 1.0

    def _sweep(self, nu: Array, base: Array, fresh: Array, scale: Array, priors: list[Prior], judged: list[int]) -> Sweep:
        c = np.flatnonzero(~np.isnan(nu))
        R = fresh * scale
        normal, by_modes = _normal_evidence(nu, base, R), 0.0
        likelihood = np.ones(self.belief.shape)
        innovations, variances = np.zeros(len(nu)), np.zeros(len(nu))
        for i in judged:
            a = int(np.flatnonzero(c == i)[0])
            inverse = np.linalg.inv(base[np.ix_(c, c)] + np.diag(R[c]))
            spread = 1 / inverse[a, a]
            r = inverse[a] @ nu[c] * spread
            others = max(0.0, spread - R[i])
            variance = others + fresh[i] * np.append(self.levels, 1)
            variance[-1] += self.tracked_variance[i]
            mean = np.append(np.zeros(len(self.levels)), self.tracked[i])
            log_likelihood = np.asarray(norm.logpdf(r, mean, np.sqrt(variance)))
            largest = log_likelihood.max()
            likelihood[i] = np.exp(log_likelihood - largest)
            posterior = priors[i].all * likelihood[i]
            by_modes += np.log(posterior.sum()) + largest - norm.logpdf(r, 0, np.sqrt(spread))
            R[i] = fresh[i] / max(posterior @ self.precision / posterior.sum(), self.least_precision)
            innovations[i], variances[i] = r, others + fresh[i]
        return Sweep(normal + by_modes, by_modes, likelihood, innovations, variances)


def _normal_evidence(nu: Array, base: Array, R: Array) -> float:
    """log N(nu; 0, base + R) of the measured channels."""
    c = np.flatnonzero(~np.isnan(nu))
    S = base[np.ix_(c, c)] + np.diag(R[c])
    return -0.5 * float(nu[c] @ np.linalg.solve(S, nu[c]) + np.linalg.slogdet(2 * np.pi * S)[1])
