"""The filter for coloured INS errors again in NumPy, slow and readable: the oracle of the tests.

Dense matrices, one expression for each equation, no structure exploited; equation numbers are those of Hajiyev and Hacizade
(WSEAS Trans. Systems and Control 18, 2023). Written from the equations, not from the C++.
"""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag
from scipy.stats import chi2

from hnav.filters.ins_error import InsErrorOptions, InsErrorRun
from hnav.filters.linear_model import LinearModel
from hnav.native.arrays import Array
from twins.joint_hypotheses import JointHypotheses

PRINTED = ("mdkf", "amdkf")


def _or(matrix: Array | None, default: Array) -> Array:
    return default if matrix is None else matrix


class NoiseScale:
    """Factor on the variance of the white noise of each channel; `fault` is the probability that it is above 1."""

    def __init__(self, options: InsErrorOptions, nz: int):
        self.o = options
        self.mode = "none" if options.form in PRINTED else options.noise_scaling.replace("joint", "hmm")
        self.scale, self.fault = np.ones(nz), np.zeros(nz)
        self.windows: list[deque[tuple[float, float, float]]] = [deque(maxlen=options.window) for _ in range(nz)]
        n = options.hmm_levels
        self.levels = options.hmm_level_ratio ** np.arange(n)
        self.belief = np.zeros((nz, n))
        self.belief[:, 0] = 1
        T = np.zeros((n, n))
        T[0, 0], T[0, 1:] = 1 - options.hmm_fault_probability, options.hmm_fault_probability / (n - 1)
        for g in range(1, n):
            T[g, 0] = options.hmm_recovery_probability
            neighbours = [h for h in (g - 1, g + 1) if 1 <= h < n]
            for h in neighbours:
                T[g, h] = options.hmm_drift_probability / len(neighbours)
            T[g, g] = 1 - T[g].sum()
        self.transition = T

    def update(self, nu: Array, base: Array, fresh: Array, past: Array, past_healthy: Array) -> None:
        """nu: NaN where missing; base: S without the noise; fresh: Qv_ii; past: noise of earlier samples, as scaled."""
        c = np.flatnonzero(~np.isnan(nu))
        if self.mode == "none":
            return
        if self.mode == "hmm":
            adapted = fresh > 0
            self.belief[adapted] = self.belief[adapted] @ self.transition
            self._conclude(adapted)
            R = fresh * self.scale + past
            S_inverse = np.linalg.inv(base[np.ix_(c, c)] + np.diag(R[c]))
            spread = 1 / np.diag(S_inverse)
            conditional = S_inverse @ nu[c] * spread
            for a, i in enumerate(c):
                if not adapted[i]:
                    continue
                variance = max(0, spread[a] - R[i]) + past[i] + self.levels * fresh[i]
                log_likelihood = -0.5 * (np.log(variance) + conditional[a] ** 2 / variance)
                weight = self.belief[i] * np.exp(log_likelihood - log_likelihood.max())
                self.belief[i] = weight / weight.sum()
            self._conclude(adapted)
            return
        R = fresh + past_healthy
        S_inverse = np.linalg.inv(base[np.ix_(c, c)] + np.diag(R[c]))
        normalised = (S_inverse @ nu[c]) ** 2 / np.diag(S_inverse)
        gated = self.mode == "gated_match"
        for a, i in enumerate(c):
            if not fresh[i] > 0:
                continue
            window = self.windows[i]
            window.append((nu[i] ** 2, base[i, i], normalised[a]))
            if len(window) < self.o.window:
                continue
            squared, predicted, tested = np.mean(window, axis=0)
            is_open = not gated or tested * self.o.window > chi2.isf(self.o.gate_alpha, self.o.window)
            self.scale[i] = max(1, (squared - (predicted if gated else base[i, i])) / R[i]) if is_open else 1
            self.fault[i] = gated and is_open

    def _conclude(self, channels: npt.NDArray[np.bool_]) -> None:
        self.scale[channels] = 1 / (self.belief[channels] @ (1 / self.levels))
        self.fault[channels] = self.belief[channels, 1:].sum(axis=1)


class ReferenceInsError:
    """The same calls and outputs as InsErrorFilter."""

    def __init__(self, model: LinearModel, options: InsErrorOptions | None = None):
        self.o = options = options or InsErrorOptions()
        self.m = m = model.discrete()
        self.coloured = m.An is not None
        nz = m.nz
        zero = np.zeros((nz, nz))
        G, Bn, QU = _or(m.G, np.eye(m.nx)), _or(m.Bn, zero), _or(m.QU, zero)
        self.B, x0 = _or(m.B, np.zeros((m.nx, 0))), _or(m.x0, np.zeros(m.nx))
        self.An, self.Lambda0 = _or(m.An, zero), _or(m.Lambda0, zero) if self.coloured else zero
        self.Q: Array = G @ m.Qw @ G.T
        self.Ql: Array = Bn @ QU @ Bn.T if self.coloured else zero
        self.Hd: Array = m.H @ m.A - self.An @ m.H
        self.C: Array = self.Q @ m.H.T
        self.driven: Array = m.H @ self.Q @ m.H.T + self.Ql
        self.R: Array = self.driven + m.Qv + self.An @ m.Qv @ self.An.T
        self.F: Array
        self.Qa: Array
        self.Ba: Array
        self.Ha: Array
        self.x: Array
        self.P: Array
        self.augmented = options.form == "augmented" and self.coloured
        self.joint = JointHypotheses(options, nz) if self.augmented and options.noise_scaling == "joint" else None
        self.noise = NoiseScale(options, nz)
        if self.augmented:
            self.F, self.Qa = block_diag(m.A, self.An), block_diag(self.Q, self.Ql)
            self.Ba, self.Ha = np.vstack([self.B, np.zeros((nz, m.nu))]), np.hstack([m.H, np.eye(nz)])
            self.x, self.P = np.r_[x0, np.zeros(nz)], block_diag(m.P0, self.Lambda0)
            self.extra = zero
        else:
            self.F, self.Qa, self.Ba, self.Ha = m.A, self.Q, self.B, m.H
            self.x, self.P = x0.copy(), m.P0.copy()
            self.extra = self.Lambda0
        self.steps = 0
        self.z: Array = np.full(nz, np.nan)
        self.shown = (self.x, self.P)
        self.innovation: Array = np.full(nz, np.nan)
        self.S: Array = np.full((nz, nz), np.nan)
        self.nis = np.nan
        self.z_shown: Array = self.z
        self.u_before: Array = np.zeros(m.nu)
        self.window: deque[Array] = deque(maxlen=options.window)
        self.s: Array = np.ones(nz)  # of AMDKF
        self.v_before: Array = np.zeros(nz)

    def step(self, held: npt.ArrayLike, seen: npt.ArrayLike) -> None:
        """One step: u, held since the last one, and z."""
        u, z = np.atleast_1d(np.asarray(held, np.float64)), np.asarray(seen, np.float64)
        z_before, self.z = self.z, z
        form = self.o.form
        if form in PRINTED:
            if self.steps > 0:
                self._printed(u, z, z_before)
            self.shown = (self.x, self.P)
        elif form == "differenced":
            self._differenced(u, z, z_before)
        else:
            self._kalman(u, z)
        self.z_shown = z_before if self.steps > 0 and (form in PRINTED or self.o.lag) else z
        self.steps += 1

    def _solve(self, S: Array, right: Array) -> Array:
        """S^-1 right on the channels with a measurement; zero rows elsewhere."""
        c = np.flatnonzero(~np.isnan(self.innovation))
        out = np.zeros_like(right)
        if len(c):
            out[c] = np.linalg.solve(S[np.ix_(c, c)], right[c])
        return out

    def _conclude(self, S: Array) -> Array:
        nu: Array = np.nan_to_num(self.innovation)
        self.S = S
        self.nis = float(nu @ self._solve(S, nu)) if np.isfinite(self.innovation).any() else np.nan
        return nu

    # ------------------------------------------------------------------------------------- augmented, plain

    def _kalman(self, u: Array, z: Array) -> None:
        x_before, P_before = self.x, self.P
        if self.steps > 0:
            self.x = self.F @ self.x + self.Ba @ u
            self.P = self.F @ self.P @ self.F.T + self.Qa
        H, Qv = self.Ha, self.m.Qv
        self.innovation = z - H @ self.x
        base = H @ self.P @ H.T + self.extra
        zero = np.zeros(self.m.nz)
        Q = self.Qa
        if self.joint:
            self.joint.update(self.innovation, base, np.diag(Qv), self.m.H @ self.Q @ self.m.H.T, self.Ql, self.steps > 0)
            opened = np.r_[np.zeros(self.m.nx), self.joint.opened]
            Q = block_diag(self.joint.motion * self.Q, self.joint.colour * self.Ql) + np.diag(opened)
            self.P = self.P + Q - self.Qa
        else:
            self.noise.update(self.innovation, base, np.diag(Qv), zero, zero)
        R = self._white() + self.extra
        S = H @ self.P @ H.T + R
        nu = self._conclude(S)
        if self.steps > 0 and self.o.lag:
            D = self._solve(S, H @ self.F @ P_before).T
            self.shown = (x_before + D @ nu, P_before - D @ S @ D.T)
        K = self._solve(S, H @ self.P).T
        self.x = self.x + K @ nu
        E = np.eye(len(self.x)) - K @ H
        self.P = E @ self.P @ E.T + K @ R @ K.T
        if not (self.steps > 0 and self.o.lag):
            self.shown = (self.x, self.P)

    # ------------------------------------------------------------------------------------- differencing

    def _difference(self, u: Array, z: Array, z_before: Array) -> Array:
        late = np.array([row[row != 0] @ z_before[row != 0] for row in self.An])  # NaN only where it is needed
        difference: Array = z - late - self.m.H @ self.B @ u - self.Hd @ self.x
        return difference

    def _printed(self, u: Array, z: Array, z_before: Array) -> None:
        """(12)-(24); mu(k) = z(k+1) - An z(k) corrects x(k)."""
        m = self.m
        if self.steps > 1:
            self.x = m.A @ self.x + self.B @ self.u_before
            self.P = m.A @ self.P @ m.A.T + self.Q
        self.u_before = u
        self.innovation = self._difference(u, z, z_before)
        base = self.Hd @ self.P @ self.Hd.T + self.Hd @ self.C + self.C.T @ self.Hd.T
        if self.o.form == "amdkf" and np.isfinite(self.innovation).any():
            self.window.append(self.innovation)
            if len(self.window) == self.o.window:
                d = np.array(self.window)
                products = d[:, :, None] * d[:, None, :]
                seen = np.isfinite(products).any(axis=0)
                sample = np.where(
                    seen, np.nansum(products, axis=0) / np.maximum(1, np.isfinite(products).sum(axis=0)), base + self.R
                )
                self.s = np.maximum(1, np.diag((sample - base) @ np.linalg.pinv(self.R)))
        Omega = base + self.s[:, None] * self.R
        nu = self._conclude(Omega)
        c = np.flatnonzero(np.isfinite(self.innovation))
        K = np.zeros((m.nx, m.nz))
        if len(c):
            K[:, c] = (self.P @ self.Hd.T + self.C)[:, c] @ np.linalg.inv(Omega[np.ix_(c, c)])
        self.x = self.x + K @ nu
        P = self.P - K @ (base + self.R) @ K.T  # (16), which (24) does not reach
        self.P = 0.5 * (P + P.T)

    def _white(self) -> Array:
        root = np.sqrt((self.joint or self.noise).scale)
        scaled: Array = root[:, None] * self.m.Qv * root
        return scaled

    def _differenced(self, u: Array, z: Array, z_before: Array) -> None:
        m, An, Hd = self.m, self.An, self.Hd
        if self.steps == 0:
            self._kalman(u, z)
            self.v_before = self.noise.scale * np.diag(m.Qv)
            return
        self.innovation = self._difference(u, z, z_before)
        healthy = An @ m.Qv @ An.T
        diagonal = np.array_equal(m.Qv, np.diag(np.diag(m.Qv)))
        old = An @ np.diag(self.v_before) @ An.T if diagonal else healthy
        base = Hd @ self.P @ Hd.T + self.driven + old - np.diag(np.diag(old))
        self.noise.update(self.innovation, base, np.diag(m.Qv), np.diag(old), np.diag(healthy))
        R = old + self._white()
        S = Hd @ self.P @ Hd.T + self.driven + R
        nu = self._conclude(S)
        self.v_before = self.noise.scale * np.diag(m.Qv)
        if self.o.lag:
            D = self._solve(S, Hd @ self.P).T
            self.shown = (self.x + D @ nu, self.P - D @ S @ D.T)
        K = self._solve(S, (m.A @ self.P @ Hd.T + self.C).T).T
        self.x = m.A @ self.x + self.B @ u + K @ nu
        E, G = m.A - K @ Hd, np.eye(m.nx) - K @ m.H
        self.P = E @ self.P @ E.T + G @ self.Q @ G.T + K @ (self.Ql + R) @ K.T
        if not self.o.lag:
            self.shown = (self.x, self.P)

    # ------------------------------------------------------------------------------------- outputs

    def outputs(self) -> InsErrorRun:
        """The present outputs: one row of a run."""
        nx, H = self.m.nx, self.m.H
        x, P = self.shown
        lam = x[nx:] if self.augmented else self.z_shown - H @ x[:nx]
        variance = np.diag(P)[nx:] if self.augmented else np.diag(H @ P @ H.T)
        return InsErrorRun(
            x=x[:nx], sigma=np.sqrt(np.maximum(0, np.diag(P)[:nx])), covariance=P[:nx, :nx], lam=lam,
            lam_sigma=np.sqrt(np.maximum(0, variance)), compensated=self.z_shown - lam, innovation=self.innovation,
            nis=np.array(self.nis), noise_scale=self.s if self.o.form in PRINTED else (self.joint or self.noise).scale,
            fault_probability=self.joint.noise if self.joint else self.noise.fault,
            bias_fault_probability=self.joint.bias if self.joint else np.zeros(self.m.nz),
            process_fault_probability=np.array(self.joint.process if self.joint else 0.0),
        )  # fmt: skip


def run_reference(model: LinearModel, options: InsErrorOptions, u: npt.ArrayLike, z: npt.ArrayLike) -> InsErrorRun:
    """Arrays as InsErrorFilter.run takes and gives them."""
    held, seen = np.asarray(u), np.asarray(z)
    f = ReferenceInsError(model, options)
    rows = []
    for k in range(len(seen)):
        f.step(held[k], seen[k])
        rows.append({name: np.copy(value) for name, value in vars(f.outputs()).items()})
    return InsErrorRun(**{name: np.array([row[name] for row in rows]) for name in rows[0]})
