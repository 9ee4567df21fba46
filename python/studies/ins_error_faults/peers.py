"""Methods of the literature for noise that differs from the stated one, on the augmented model, all flights at once.

    IAE           covariance matching over the last innovations                  Mohamed and Schwarz, J. Geodesy 73, 1999
    Sage-Husa     the same with fading memory                                    Sage and Husa, JACC 1969
    VB            the noise is inverse gamma, found with the state               Huang et al., IEEE Trans. AC 63(2), 2018
    IMM           a filter for each hypothesis, mixed before each step           Blom and Bar-Shalom, IEEE Trans. AC 33(8), 1988

None of them reduces the noise below the stated one, except the IMM, whose hypotheses have fixed levels.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from scipy.linalg import block_diag

from hnav.simulation.aircraft import Aircraft
from hnav.systems.statistics import normalised_squares
from twins.aircraft import Flight, model_of

ALARM = 4.0  # factor on the variance that counts as saying that a channel is at fault


@dataclass
class Result:
    error: np.ndarray  # runs x (steps + 1) x n: estimate minus truth of the same step, NaN where there is none
    nees: np.ndarray  # runs x (steps + 1)
    fault_probability: np.ndarray  # runs x (steps + 1) x n
    noise_scale: np.ndarray
    bias_fault_probability: np.ndarray | float = 0.0  # as fault_probability; 0 of a filter that does not judge it
    process_fault_probability: np.ndarray | float = 0.0  # runs x (steps + 1)

    def rmse(self, window: slice) -> np.ndarray:
        """runs x n"""
        return np.asarray(np.sqrt(np.mean(self.error[:, window] ** 2, axis=1)))


class Model:
    """F, Q, H, r = diag R and the start of X = [x; lambda]."""

    def __init__(self, plane: Aircraft):
        m = model_of(plane).discrete()
        G, Bn = m.matrix("G"), m.matrix("Bn")
        self.n, self.r = m.nx, np.diag(m.Qv)
        self.F, self.B = block_diag(m.A, m.matrix("An")), np.vstack([m.matrix("B"), np.zeros((m.nz, m.nu))])
        self.Q, self.H = block_diag(G @ m.Qw @ G.T, Bn @ m.matrix("QU") @ Bn.T), np.hstack([m.H, np.eye(m.nz)])
        self.P0 = block_diag(m.P0, m.matrix("Lambda0"))

    def predict(self, x: np.ndarray, P: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x @ self.F.T + self.B @ u, self.F @ P @ self.F.T + self.Q

    def innovation_covariance(self, P: np.ndarray, R: np.ndarray) -> np.ndarray:
        return np.asarray(self.H @ P @ self.H.T + R[..., None] * np.eye(self.n))

    def correct(self, x: np.ndarray, P: np.ndarray, z: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """R: runs x n variances."""
        K = np.linalg.solve(self.innovation_covariance(P, R), self.H @ P).swapaxes(-1, -2)
        E = np.eye(2 * self.n) - K @ self.H
        after = E @ P @ E.swapaxes(-1, -2) + (K * R[..., None, :]) @ K.swapaxes(-1, -2)
        return x + np.einsum("...ij,...j->...i", K, z - x @ self.H.T), 0.5 * (after + after.swapaxes(-1, -2))

    def expected(self, P: np.ndarray) -> np.ndarray:
        """Variance of each channel without white noise."""
        return np.asarray(np.einsum("ij,njk,ik->ni", self.H, P, self.H))


class Peer(ABC):
    """correct() answers state, covariance and the noise that it took, for all runs."""

    def __init__(self, plane: Aircraft, runs: int):
        self.m = Model(plane)
        self.x = np.zeros((runs, 2 * self.m.n))
        self.P = np.broadcast_to(self.m.P0, (runs, *self.m.P0.shape))

    @abstractmethod
    def correct(self, z: np.ndarray) -> np.ndarray: ...

    def step(self, u: np.ndarray | None, z: np.ndarray) -> np.ndarray:
        """The factors on the variance of the noise."""
        if u is not None:
            self.x, self.P = self.m.predict(self.x, self.P, u)
        return self.correct(z)


class Oracle(Peer):
    """Has the true noise of every step, a bound for any adaptation. Its gains do not depend on the data: all flights share a covariance."""

    def __init__(self, plane: Aircraft, runs: int, flight: Flight):
        super().__init__(plane, runs)
        self.P, self.factors = self.m.P0[None], iter(flight.noise_factor**2)

    def correct(self, z: np.ndarray) -> np.ndarray:
        factor = next(self.factors)
        self.x, self.P = self.m.correct(self.x, self.P, z, factor[None] * self.m.r)
        return np.broadcast_to(factor, z.shape)


class Matched(Peer):
    """IAE."""

    def __init__(self, plane: Aircraft, runs: int):
        super().__init__(plane, runs)
        self.window: deque[np.ndarray] = deque(maxlen=20)

    def noise(self, square: np.ndarray) -> np.ndarray:
        self.window.append(square)
        full = len(self.window) == self.window.maxlen
        return np.asarray(np.mean(self.window, axis=0) - self.m.expected(self.P) if full else self.m.r + 0 * square)

    def correct(self, z: np.ndarray) -> np.ndarray:
        R = np.maximum(self.m.r, self.noise((z - self.x @ self.m.H.T) ** 2))
        self.x, self.P = self.m.correct(self.x, self.P, z, R)
        return np.asarray(R / self.m.r)


class SageHusa(Matched):
    FORGETS = 0.05

    def __init__(self, plane: Aircraft, runs: int):
        super().__init__(plane, runs)
        self.R = np.broadcast_to(self.m.r, (runs, self.m.n))

    def noise(self, square: np.ndarray) -> np.ndarray:
        self.R = np.maximum(self.m.r, (1 - self.FORGETS) * self.R + self.FORGETS * (square - self.m.expected(self.P)))
        return self.R


class Variational(Peer):
    KEEPS, PASSES = 0.95, 3

    def __init__(self, plane: Aircraft, runs: int):
        super().__init__(plane, runs)
        self.shape = np.full((runs, self.m.n), 0.5 / (1 - self.KEEPS))
        self.rate = self.shape * self.m.r

    def correct(self, z: np.ndarray) -> np.ndarray:
        self.shape = self.KEEPS * self.shape + 0.5
        before = self.KEEPS * self.rate
        rate = before + 0.5 * self.m.r
        for _ in range(self.PASSES):
            R = rate / self.shape
            x, P = self.m.correct(self.x, self.P, z, R)
            rate = before + 0.5 * ((z - x @ self.m.H.T) ** 2 + self.m.expected(P))
        self.x, self.P, self.rate = x, P, rate
        return np.asarray(R / self.m.r)


class Multiple(Peer):
    """IMM of twelve hypotheses about the noise: none, one channel at one of two levels, two of the pairs, all channels."""

    STAYS_HEALTHY, STAYS = 0.998, 0.98

    def __init__(self, plane: Aircraft, runs: int):
        super().__init__(plane, runs)
        n = self.m.n
        factors = [np.ones(n)]
        for channels, level in [*product(([i] for i in range(n)), (16, 64)), ([0, 1], 36), ([2, 3], 36), (range(n), 36)]:
            factors.append(np.where(np.isin(np.arange(n), list(channels)), level, 1.0))
        self.factors = np.array(factors)
        count = len(factors)
        self.transition = np.full((count, count), (1 - self.STAYS) / (count - 1))
        self.transition[0] = (1 - self.STAYS_HEALTHY) / (count - 1)
        np.fill_diagonal(self.transition, [self.STAYS_HEALTHY, *[self.STAYS] * (count - 1)])
        self.belief = np.tile(np.eye(count)[0], (runs, 1))
        self.each_x = np.broadcast_to(self.x, (count, *self.x.shape))
        self.each_P = np.broadcast_to(self.P, (count, *self.P.shape))

    @staticmethod
    def mixed(weight: np.ndarray, x: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """weight: hypotheses x runs, sums to one over hypotheses."""
        mean = np.einsum("jn,jna->na", weight, x)
        away = x - mean
        return mean, np.einsum("jn,jnab->nab", weight, P) + np.einsum("jn,jna,jnb->nab", weight, away, away)

    def step(self, u: np.ndarray | None, z: np.ndarray) -> np.ndarray:
        prior = self.belief @ self.transition
        log_belief = np.log(np.maximum(prior, 1e-300))
        answers = []
        for j, factor in enumerate(self.factors):
            weight = (self.belief * self.transition[:, j] / np.maximum(prior[:, j : j + 1], 1e-300)).T
            x, P = self.mixed(weight, self.each_x, self.each_P)
            if u is not None:
                x, P = self.m.predict(x, P, u)
            R = np.broadcast_to(factor * self.m.r, z.shape)
            S, nu = self.m.innovation_covariance(P, R), z - x @ self.m.H.T
            log_belief[:, j] -= 0.5 * (np.linalg.slogdet(S)[1] + normalised_squares(nu, S))
            answers.append(self.m.correct(x, P, z, R))
        self.each_x, self.each_P = (np.array(values) for values in zip(*answers))
        self.belief = np.exp(log_belief - log_belief.max(axis=1, keepdims=True))
        self.belief /= self.belief.sum(axis=1, keepdims=True)
        self.x, self.P = self.mixed(self.belief.T, self.each_x, self.each_P)
        return self.correct(z)

    def correct(self, z: np.ndarray) -> np.ndarray:
        """Of each channel: likely at fault or not."""
        return np.where(self.belief @ (self.factors > 1) > 0.5, 2 * ALARM, 1.0)


PEERS: dict[str, type[Peer]] = {"VB": Variational, "Sage-Husa": SageHusa, "IAE 20": Matched, "IMM 12": Multiple}


def run_oracle(plane: Aircraft, flight: Flight) -> Result:
    return run_peer(partial(Oracle, flight=flight), plane, flight)


def run_peer(kind: Callable[[Aircraft, int], Peer], plane: Aircraft, flight: Flight) -> Result:
    peer = kind(plane, len(flight.z))
    n = peer.m.n
    error, nees, scale = np.empty(flight.x.shape), np.empty(flight.x.shape[:2]), np.empty(flight.x.shape)
    for k in range(flight.z.shape[1]):
        scale[:, k] = peer.step(flight.u[k] if k > 0 else None, flight.z[:, k])
        error[:, k] = peer.x[:, :n] - flight.x[:, k]
        nees[:, k] = normalised_squares(error[:, k], peer.P[:, :n, :n])
    return Result(error, nees, (scale > ALARM).astype(float), scale)
