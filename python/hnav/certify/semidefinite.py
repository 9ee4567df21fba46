"""Semidefinite programs of the certificate: the least cost'x for which F(x) - C >= 0 in every block.

A primal-dual interior point method (infeasible start, direction of Helmberg, Kojima and Monteiro, corrector of Mehrotra; Helmberg, Rendl,
Vanderbei, Wolkowicz, SIAM J. Optim. 6, 1996). With slack X = F(x) - C and multipliers Z, X Z = mu I, each step solves H dx = rhs with
H_ij = sum tr(F_i X^-1 F_j Z). General solvers form a matrix of the size of all triangles; here there are far fewer unknowns than that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.linalg import LinAlgError
from scipy.linalg import cho_factor, cho_solve

N = 6  # of P
_ELEMENT = np.eye(N * N).reshape(N, N, N * N)  # of row and column, as a column
# N^2 x elements: what one element of P adds to P
BASIS = np.array([np.maximum(_ELEMENT[i, j], _ELEMENT[j, i]) for i, j in zip(*np.triu_indices(N))]).T
ITERATIONS, GAP, RESIDUAL = 60, 1e-3, 1e-7  # a question that can be answered takes 10 to 25; the cost is needed roughly
LARGEST_COST = 1e9  # in units of the start: beyond, the blocks contradict one another
CLOSER, SHORTER, SHORTEST = 0.9, 0.7, 1e-4  # share of a step to the boundary, next try, step that ends the search
SHORT = 0.1  # a predictor that goes no further says nothing about mu
RIDGE = 1e-14  # on the diagonal of H


class Blocks(Protocol):
    """Blocks of one size; matrices are blocks x n x n."""

    constant: np.ndarray  # C
    unknowns: np.ndarray  # blocks x those a block depends on

    def value(self, x: np.ndarray) -> np.ndarray:
        """F(x)."""
        ...

    def adjoint(self, Z: np.ndarray) -> np.ndarray:
        """tr(F_i Z) for each block and each of its unknowns; Z need not be symmetric."""
        ...

    def products(self, Y: np.ndarray, Z: np.ndarray) -> np.ndarray:
        """tr(F_i Y F_j Z) for each block."""
        ...


@dataclass
class DenseBlocks:
    """Small blocks, with F (blocks x n x n x unknowns) in full."""

    F: np.ndarray
    unknowns: np.ndarray
    constant: np.ndarray

    def value(self, x: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("kabi,ki->kab", self.F, x[self.unknowns]))

    def adjoint(self, Z: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("kabi,kab->ki", self.F, Z))

    def products(self, Y: np.ndarray, Z: np.ndarray) -> np.ndarray:
        F = np.moveaxis(self.F, -1, 1)
        flat, turned = F.reshape(*F.shape[:2], -1), (Z[:, None] @ F @ Y[:, None]).reshape(*F.shape[:2], -1)
        return np.asarray(flat @ np.swapaxes(turned, 1, 2))


class CorrectionBlocks:
    """X_k = blkdiag(share P_before, 0) - B'P_after B - sum tau_i F_i of corrections: elements of both P, then tau.

    Both P enter as S'ES, so that tr(S'E_i S Y S'E_j S Z) follows from S Y S' and S Z S', which are as small as P.
    """

    def __init__(self, share: np.ndarray, B: np.ndarray, forms: np.ndarray, unknowns: np.ndarray, constant: np.ndarray):
        m, z = len(B), B.shape[2]
        self.unknowns, self.constant, self.minus_forms = unknowns, constant, -forms
        first = np.sqrt(share)[:, None, None] * np.broadcast_to(np.eye(N, z), (m, N, z))
        self.S, self.sign = np.stack([first, B], axis=1), np.array([1.0, -1.0])  # of both P

    def value(self, x: np.ndarray) -> np.ndarray:
        here, elements = x[self.unknowns], BASIS.shape[1]
        P = (here[:, : 2 * elements].reshape(-1, 2, elements) @ BASIS.T).reshape(-1, 2, N, N)
        S = self.S
        both = np.swapaxes(S, 2, 3) @ P @ S
        return np.asarray(both[:, 0] - both[:, 1] + np.einsum("ki,kiab->kab", here[:, 2 * elements :], self.minus_forms))

    def _of_both(self, S_Z_S: np.ndarray) -> np.ndarray:
        """tr(E_i S Z S'), ... x 2 x elements, of S Z S' (... x 2 x N x N)."""
        return np.asarray(self.sign[:, None] * (S_Z_S.reshape(*S_Z_S.shape[:-2], N * N) @ BASIS))

    def adjoint(self, Z: np.ndarray) -> np.ndarray:
        m = len(Z)
        of_P = self._of_both(self.S @ Z[:, None] @ np.swapaxes(self.S, 2, 3)).reshape(m, -1)
        return np.concatenate([of_P, np.einsum("kiab,kab->ki", self.minus_forms, Z)], axis=1)

    def products(self, Y: np.ndarray, Z: np.ndarray) -> np.ndarray:
        m, elements, count = len(Y), BASIS.shape[1], self.minus_forms.shape[1]
        found = np.empty((m, 2 * elements + count, 2 * elements + count))
        S, St = self.S, np.swapaxes(self.S, 2, 3)
        SY, SZ = S @ Y[:, None], S @ Z[:, None]
        for p in range(2):
            for q in range(p, 2):
                # sum E_i[a,b] (S_p Y S_q')[b,c] E_j[c,d] (S_q Z S_p')[d,a]
                inner, outer = SY[:, p] @ St[:, q], SZ[:, q] @ St[:, p]
                T = np.swapaxes(outer, 1, 2)[:, :, None, None, :] * inner[:, None, :, :, None]
                part = self.sign[p] * self.sign[q] * (BASIS.T @ T.reshape(m, N * N, N * N) @ BASIS)
                found[:, p * elements : (p + 1) * elements, q * elements : (q + 1) * elements] = part
                found[:, q * elements : (q + 1) * elements, p * elements : (p + 1) * elements] = np.swapaxes(part, 1, 2)
        if count:
            turned = Z[:, None] @ self.minus_forms @ Y[:, None]
            of_P = self._of_both(S[:, None] @ turned[:, :, None] @ St[:, None]).reshape(m, count, -1)
            found[:, 2 * elements :, : 2 * elements] = of_P
            found[:, : 2 * elements, 2 * elements :] = np.swapaxes(of_P, 1, 2)
            flat = self.minus_forms.reshape(m, count, -1)
            found[:, 2 * elements :, 2 * elements :] = flat @ np.swapaxes(turned.reshape(m, count, -1), 1, 2)
        return found


def symmetric_part(A: np.ndarray) -> np.ndarray:
    """Of matrices on the last two axes."""
    return np.asarray(0.5 * (A + np.swapaxes(A, -1, -2)))


def _longest_step(A: list[np.ndarray], dA: list[np.ndarray]) -> float:
    """Up to 1, so that A + step dA > 0 stays some way from the boundary; 0 where none is left."""
    step = 1.0
    for a, d in zip(A, dA):
        while step > SHORTEST:
            try:
                np.linalg.cholesky(a + step / CLOSER * d)
                break
            except LinAlgError:
                step *= SHORTER
    return step if step > SHORTEST else 0.0


Matrices = list[np.ndarray]  # of each group


def _product(A: Matrices, B: Matrices) -> float:
    return sum(float(np.sum(a * b)) for a, b in zip(A, B))


def _moved(A: Matrices, step: float, dA: Matrices) -> Matrices:
    return [symmetric_part(a + step * d) for a, d in zip(A, dA)]


class _Iterate:
    """x, the slack X and the multipliers Z, and the steps that improve them."""

    def __init__(self, cost: np.ndarray, groups: Sequence[Blocks]):
        self.cost, self.groups, n = cost, groups, len(cost)
        self.C = [g.constant for g in groups]
        self.rows = np.concatenate([g.unknowns.ravel() for g in groups])
        self.elements = np.concatenate([(g.unknowns[:, :, None] * n + g.unknowns[:, None, :]).ravel() for g in groups])
        self.order = sum(len(c) * c.shape[1] for c in self.C)
        self.begin = 10.0 * max(1.0, float(np.abs(cost).max()))
        self.x = np.zeros(n)
        self.X = [np.broadcast_to(self.begin * np.eye(c.shape[1]), c.shape).copy() for c in self.C]
        self.Z = [slack.copy() for slack in self.X]

    def look(self) -> bool | None:
        """Whether the program is solved; None where its blocks contradict one another."""
        self.missing = [g.value(self.x) - c - slack for g, c, slack in zip(self.groups, self.C, self.X)]
        self.mu = _product(self.X, self.Z) / self.order
        if _product(self.C, self.Z) > LARGEST_COST * self.begin:  # a lower bound of the cost
            return None
        feasible = max(float(np.abs(r).max()) for r in self.missing) < RESIDUAL
        return feasible and self.order * self.mu < GAP * (1 + abs(float(self.cost @ self.x)))

    def factor(self) -> None:
        """H, scaled to a diagonal of 1. Raises LinAlgError where it is not positive."""
        n = len(self.cost)
        self.Y = [np.linalg.inv(slack) for slack in self.X]
        each = np.concatenate([g.products(y, z).ravel() for g, y, z in zip(self.groups, self.Y, self.Z)])
        H = symmetric_part(np.bincount(self.elements, each, n * n).reshape(n, n))
        self.size = np.sqrt(np.where(np.diag(H) > 0, np.diag(H), 1))  # an unknown that no block depends on stays 0
        self.H = cho_factor(H / np.outer(self.size, self.size) + RIDGE * np.eye(n))

    def direction(self, mu: float, second: Sequence[np.ndarray | float]) -> tuple[np.ndarray, Matrices, Matrices]:
        """Of x, X and Z towards X Z = mu I; second: the part of second order, dX dZ, as known."""
        fixed = [mu * y - symmetric_part(y @ (r @ z + s)) for y, r, z, s in zip(self.Y, self.missing, self.Z, second)]
        each = np.concatenate([g.adjoint(f).ravel() for g, f in zip(self.groups, fixed)])
        dx = cho_solve(self.H, (np.bincount(self.rows, each, len(self.cost)) - self.cost) / self.size) / self.size
        step = [g.value(dx) for g in self.groups]
        dZ = [f - z - symmetric_part(y @ s @ z) for f, z, y, s in zip(fixed, self.Z, self.Y, step)]
        return dx, [s + r for s, r in zip(step, self.missing)], dZ

    def improve(self) -> bool:
        """One step of predictor and corrector; False where none is left."""
        _, dX, dZ = self.direction(0.0, [0.0] * len(self.C))
        a, b = _longest_step(self.X, dX), _longest_step(self.Z, dZ)
        reached = _product(_moved(self.X, a, dX), _moved(self.Z, b, dZ)) / self.order / self.mu
        share = min(1.0, reached) ** 3 if min(a, b) > SHORT else 0.5
        dx, dX, dZ = self.direction(share * self.mu, [p @ q for p, q in zip(dX, dZ)])
        a, b = _longest_step(self.X, dX), _longest_step(self.Z, dZ)
        self.x, self.X, self.Z = self.x + a * dx, _moved(self.X, a, dX), _moved(self.Z, b, dZ)
        return max(a, b) > 0


def smallest(cost: np.ndarray, groups: Sequence[Blocks]) -> np.ndarray | None:
    """x, or None where the blocks contradict one another or the method finds no answer."""
    at = _Iterate(cost, groups)
    for _ in range(ITERATIONS):
        solved = at.look()
        if solved is not False:
            return at.x if solved else None
        try:
            at.factor()
        except LinAlgError:
            return None
        if not at.improve():
            return None
    return None
