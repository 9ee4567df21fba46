"""Times the augmented filter (8 states, 8 coloured errors) beside filterpy's Kalman filter on the same model and samples.

PYTHONPATH=python python c_src/bench/ins_error_peer.py

filterpy is told the stacked matrices and adapts nothing; hnav runs once likewise and once with the HMM. Rounds interleave.
"""

import statistics
import sys
import time

import numpy as np
from scipy.linalg import block_diag

from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions, LinearModel

N, STEPS, ROUNDS = 8, 1000, 9


def model() -> LinearModel:
    chain = 0.9 * np.eye(4) + 0.03 * np.array([[0, 1, -2, 1], [2, 0, 1, -1], [-1, 2, 0, 1], [1, -2, 1, 0]])
    eye = np.eye(N)
    return LinearModel(A=block_diag(chain, chain), H=eye, Qw=0.01 * eye, Qv=eye, An=0.998 * eye, QU=0.004 * eye, P0=eye)


def main() -> int:
    try:
        from filterpy.kalman import KalmanFilter
    except ImportError:
        print("ins_error_peer: filterpy is not installed, nothing to compare with", file=sys.stderr)
        return 0
    m = model().discrete()
    z = np.random.default_rng(1).normal(size=(STEPS, N))
    times = {"filterpy, no adaptation": [], "hnav, no adaptation": [], "hnav, HMM": []}
    ours = {name: InsErrorFilter(m, InsErrorOptions(noise_scaling=s)) for name, s in zip(list(times)[1:], ("none", "hmm"))}
    last = {}
    for _ in range(ROUNDS):
        peer = KalmanFilter(dim_x=2 * N, dim_z=N)
        peer.F, peer.Q = block_diag(m.A, m.An), block_diag(m.Qw, m.QU)
        peer.H, peer.R, peer.P = np.hstack([m.H, np.eye(N)]), m.Qv, block_diag(m.P0, m.Lambda0)
        begin = time.perf_counter()
        for k in range(STEPS):
            if k > 0:
                peer.predict()
            peer.update(z[k])
        times["filterpy, no adaptation"].append(time.perf_counter() - begin)
        for name, f in ours.items():
            f.reset()
            begin = time.perf_counter()
            run = f.run(None, z)
            times[name].append(time.perf_counter() - begin)
            last[name] = run.x[-1]
        assert np.allclose(last["hnav, no adaptation"], peer.x.ravel()[:N], rtol=0, atol=1e-9)
    print(f"one step of 16 states and 8 measurements, all outputs, median of {ROUNDS} rounds of {STEPS} steps")
    for name, seconds in times.items():
        print(f"{name:24} {statistics.median(seconds) / STEPS * 1e6:8.2f} us")
    return 0


if __name__ == "__main__":
    sys.exit(main())
