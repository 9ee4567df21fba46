"""Times the augmented filter (8 states, 8 coloured errors) beside filterpy's Kalman filter on the same model and samples.

    ./run study ins_error_peer

filterpy has the stacked matrices and no adaptation; hnav runs likewise, with the HMM and with joint hypotheses. Rounds interleave.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from hnav.cli.console import say
from hnav.cli.words import UsageError
from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.filters.linear_model import LinearModel

N, STEPS, ROUNDS = 8, 1000, 9


def model() -> LinearModel:
    chain = 0.9 * np.eye(4) + 0.03 * np.array([[0, 1, -2, 1], [2, 0, 1, -1], [-1, 2, 0, 1], [1, -2, 1, 0]])
    eye = np.eye(N)
    return LinearModel(A=block_diag(chain, chain), H=eye, Qw=0.01 * eye, Qv=eye, An=0.998 * eye, QU=0.004 * eye, P0=eye)


def peer_of(m: LinearModel, kalman_filter: type) -> Any:
    """filterpy's filter of the stacked state."""
    peer = kalman_filter(dim_x=2 * N, dim_z=N)
    peer.F, peer.Q = block_diag(m.A, m.matrix("An")), block_diag(m.Qw, m.matrix("QU"))
    peer.H, peer.R, peer.P = np.hstack([m.H, np.eye(N)]), m.Qv, block_diag(m.P0, m.matrix("Lambda0"))
    return peer


def command() -> None:
    """Prints the time of one step of hnav's filter and of filterpy's."""
    try:
        from filterpy.kalman import KalmanFilter
    except ImportError:
        raise UsageError("filterpy is not installed: there is nothing to compare with") from None
    m = model().discrete()
    z = np.random.default_rng(1).normal(size=(STEPS, N))
    times: dict[str, list[float]] = {"filterpy, no adaptation": [], "hnav, no adaptation": [], "hnav, HMM": [], "hnav, joint": []}
    scalings = ("none", "hmm", "joint")
    ours = {name: InsErrorFilter(m, InsErrorOptions(noise_scaling=s)) for name, s in zip(list(times)[1:], scalings)}
    last = {}
    for _ in range(ROUNDS):
        peer = peer_of(m, KalmanFilter)
        begin = time.thread_time()
        for k in range(STEPS):
            if k > 0:
                peer.predict()
            peer.update(z[k])
        times["filterpy, no adaptation"].append(time.thread_time() - begin)
        for name, f in ours.items():
            f.reset()
            begin = time.thread_time()
            run = f.run(None, z)
            times[name].append(time.thread_time() - begin)
            last[name] = run.x[-1]
        assert np.allclose(last["hnav, no adaptation"], peer.x.ravel()[:N], rtol=0, atol=1e-9)
    say(f"one step of 16 states and 8 measurements, all outputs, us of the processor, {ROUNDS} rounds of {STEPS} steps")
    for name, seconds in times.items():
        say(f"{name:24} least {min(seconds) / STEPS * 1e6:7.2f}   median {statistics.median(seconds) / STEPS * 1e6:7.2f}")
