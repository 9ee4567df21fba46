"""Monte Carlo comparison in the form of the paper's Table 1: the paper's filters against the augmented one and the oracle.

    python -m studies.ins_error_table --runs 1000
    python -m studies.ins_error_table --runs 60 --settings 100      # the same for random noise levels, periods and intervals

Every filter sees the same flights of the F-4C (models/aircraft). A root mean square is taken over each run's fault window,
then the mean over the runs with its 95 % interval. MDKF and AMDKF estimate step k with z(k + 1), and so does "HMM, lag 1".
Equal data at equal times: AMDKF against lag 1, and AMDKF predicted to now against the others.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.linalg import block_diag

from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions
from hnav.systems.aircraft import Aircraft, Flight, models_folder, read_aircraft, simulate

STEPS = 200
BEFORE, FAULT, AFTER = slice(30, 80), slice(80, 151), slice(151, 181)
AXES = ("f4c_longitudinal", "f4c_lateral")
FILTERS = {
    "MDKF": dict(form="mdkf"),
    "AMDKF, M = 20": dict(form="amdkf", window=20),
    "AMDKF, predicted to now": dict(form="amdkf", window=20, to_now=True),
    "plain": dict(form="plain", noise_scaling="none"),
    "differenced": dict(form="differenced", noise_scaling="none"),
    "differenced, HMM": dict(form="differenced"),
    "augmented": dict(noise_scaling="none"),
    "augmented, paper match": dict(noise_scaling="paper_match"),
    "augmented, gated match": dict(noise_scaling="gated_match"),
    "augmented, HMM": dict(),
    "augmented, HMM, lag 1": dict(lag=1),
}
PAPER_NOW = "AMDKF, predicted to now"
PAPER, OURS, OURS_LATE, ORACLE = "AMDKF, M = 20", "augmented, HMM", "augmented, HMM, lag 1", "oracle"
PAIRS = ((OURS, PAPER_NOW), (OURS_LATE, PAPER), (OURS, PAPER))  # equal data twice, then one sample less for ours


@dataclass
class Result:
    error: np.ndarray  # runs x (steps + 1) x n: estimate minus truth of the same step, NaN where there is none
    nees: np.ndarray  # runs x (steps + 1)
    fault_probability: np.ndarray  # runs x (steps + 1) x n
    noise_scale: np.ndarray

    def rmse(self, window: slice) -> np.ndarray:
        """runs x n"""
        return np.sqrt(np.mean(self.error[:, window] ** 2, axis=1))


def nees_of(error: np.ndarray, P: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", error, np.linalg.solve(P, error[..., None])[..., 0])


def run_filter(aircraft: Aircraft, flight: Flight, setting: dict) -> Result:
    m = aircraft.model()
    to_now = setting.get("to_now", False)
    f = InsErrorFilter(m, InsErrorOptions(**{k: v for k, v in setting.items() if k != "to_now"}))
    late = setting.get("form") in ("mdkf", "amdkf") or setting.get("lag", 0) == 1
    error = np.full(flight.x.shape, np.nan)
    nees = np.full(flight.x.shape[:2], np.nan)
    fault, scale = np.empty(flight.x.shape), np.empty(flight.x.shape)
    for i, z in enumerate(flight.z):
        f.reset()
        run = f.run(flight.u, z)
        x, P, steps = run.x, run.covariance, slice(0, None)
        if to_now:
            x, P, steps = x[1:] @ m.A.T + flight.u[1:] @ m.B.T, m.A @ P[1:] @ m.A.T + m.Qw, slice(1, None)
        elif late:
            x, P, steps = x[1:], P[1:], slice(0, -1)
        error[i, steps] = x - flight.x[i, steps]
        nees[i, steps] = nees_of(error[i, steps], P)
        fault[i], scale[i] = run.fault_probability, run.noise_scale
    return Result(error, nees, fault, scale)


def run_oracle(aircraft: Aircraft, flight: Flight) -> Result:
    """The augmented Kalman filter that is told the noise of every step: the best any adaptation could do. Its gains do
    not depend on the data, so all runs go at once."""
    m = aircraft.model().discrete()
    n = m.nx
    F, Q, H = block_diag(m.A, m.An), block_diag(m.G @ m.Qw @ m.G.T, m.Bn @ m.QU @ m.Bn.T), np.hstack([m.H, np.eye(m.nz)])
    X, P = np.zeros((len(flight.z), n + m.nz)), block_diag(m.P0, m.Lambda0)
    error, nees = np.empty(flight.x.shape), np.empty(flight.x.shape[:2])
    for k in range(flight.z.shape[1]):
        if k > 0:
            X = X @ F.T
            X[:, :n] += m.B @ flight.u[k]
            P = F @ P @ F.T + Q
        R = m.Qv * flight.noise_factor[k][:, None] * flight.noise_factor[k]
        K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
        X = X + (flight.z[:, k] - X @ H.T) @ K.T
        E = np.eye(len(P)) - K @ H
        P = E @ P @ E.T + K @ R @ K.T
        error[:, k] = X[:, :n] - flight.x[:, k]
        nees[:, k] = nees_of(error[:, k], np.broadcast_to(P[:n, :n], (len(X), n, n)))
    true = np.broadcast_to(flight.noise_factor, flight.x.shape)
    return Result(error, nees, (true > 1).astype(float), true**2)


def compare(aircraft: Aircraft, runs: int, seed: int, filters=tuple(FILTERS)) -> tuple[Flight, dict[str, Result]]:
    flight = simulate(aircraft, runs, STEPS, seed)
    results = {name: run_filter(aircraft, flight, FILTERS[name]) for name in filters}
    return flight, results | {ORACLE: run_oracle(aircraft, flight)}


def in_display_units(aircraft: Aircraft, values: np.ndarray) -> np.ndarray:
    return values * np.array([c.display_factor for c in aircraft.channels])


@dataclass
class Alarms:
    within_10: np.ndarray  # by faulty channel: share of runs whose fault probability passes 0.5 within 10 steps
    median_delay: np.ndarray  # steps
    false_per_1000: np.ndarray  # by channel: alarms raised per 1000 healthy samples
    names: list[str]


def alarms(aircraft: Aircraft, flight: Flight, result: Result) -> Alarms:
    """An alarm is raised where the fault probability passes 0.5. Healthy samples: those without a fault now or in the 30
    steps before, which the chain may take to be sure that the channel has recovered."""
    raised = result.fault_probability > 0.5
    faulty = flight.noise_factor > 1
    delays, false, names = [], [], []
    for i, channel in enumerate(aircraft.channels):
        healthy = ~faulty[:, i]
        if faulty[:, i].any():
            first, last = np.flatnonzero(faulty[:, i])[[0, -1]]
            healthy[first : last + 31] = False
            after = raised[:, first : last + 1, i]
            delays.append(np.where(after.any(axis=1), after.argmax(axis=1), STEPS))
            names.append(channel.name)
        onset = np.diff(raised[:, :, i].astype(int), axis=1, prepend=0) > 0
        false.append(1000 * onset[:, healthy].sum() / (healthy.sum() * len(raised)))
    within = np.array([np.mean(d <= 10) for d in delays])
    return Alarms(within, np.array([np.median(d) for d in delays]), np.array(false), names)


def print_comparison(runs: int, seed: int) -> None:
    console = Console(width=200)
    planes = [read_aircraft(models_folder() / f"{axis}.json") for axis in AXES]
    both = [compare(plane, runs, seed + i) for i, plane in enumerate(planes)]
    names = [*FILTERS, ORACLE]

    table = Table(title=f"RMSE in the fault window, k = 80..150, {runs} runs, mean and 95 % interval")
    table.add_column("filter")
    for plane in planes:
        for c in plane.channels:
            table.add_column(f"{c.name} {c.display_unit}", justify="right")
    for name in names:
        cells = []
        for plane, (_, results) in zip(planes, both):
            rmse = in_display_units(plane, results[name].rmse(FAULT))
            cells += [f"{m:.4f} ±{1.96 * s / np.sqrt(runs):.4f}" for m, s in zip(rmse.mean(0), rmse.std(0))]
        table.add_row(name, *cells)
    console.print(table)

    table = Table(title="NEES/n (1 is consistent) and RMSE against the oracle: mean and worst over the 8 channels")
    for column in ("filter", "NEES/n before, lon lat", "NEES/n in fault, lon lat", "in fault", "worst", "after", "worst"):
        table.add_column(column, justify="left" if column == "filter" else "right")
    for name in names:
        ratio = {
            w: np.concatenate([r[name].rmse(s).mean(0) / r[ORACLE].rmse(s).mean(0) for _, r in both])
            for w, s in (("fault", FAULT), ("after", AFTER))
        }
        consistency = [" ".join(f"{np.mean(r[name].nees[:, s]) / 4:.2f}" for _, r in both) for s in (BEFORE, FAULT)]
        table.add_row(name, *consistency, *(f"{f(ratio[w]):.3f}" for w in ("fault", "after") for f in (np.mean, np.max)))
    console.print(table)

    for ours, theirs in PAIRS:
        better = np.concatenate([r[ours].rmse(FAULT).mean(0) < r[theirs].rmse(FAULT).mean(0) for _, r in both])
        console.print(f"{ours} better than {theirs} in the fault on {better.sum()} of 8 channels", soft_wrap=True)
    excess = [float(np.nanmean(r[PAPER].noise_scale[:, 30:80])) for _, r in both]
    console.print(
        f"{PAPER}: mean noise scale of healthy channels before the fault, lon {excess[0]:.3f}, lat {excess[1]:.3f} (1 would be unbiased)",
        soft_wrap=True,
    )
    for plane, (flight, results) in zip(planes, both):
        a = alarms(plane, flight, results[OURS])
        found = "".join(
            f"; {n} found within 10 steps in {100 * w:.1f} % of runs, median {d:.0f} steps"
            for n, w, d in zip(a.names, a.within_10, a.median_delay)
        )
        false = ", ".join(f"{c.name} {v:.2f}" for c, v in zip(plane.channels, a.false_per_1000))
        console.print(f"{plane.name}: false alarms per 1000 healthy samples {false}{found}", soft_wrap=True)


def random_setting(plane: Aircraft, rng: np.random.Generator, interval_s: float, tau_s: float) -> Aircraft:
    """Noise levels a factor of 0.2 to 5 around the file's, by channel."""
    factors = [np.exp(rng.uniform(np.log(0.2), np.log(5), len(plane.channels))) for _ in range(3)]
    return replace(
        plane, process_noise=plane.process_noise * factors[0], measurement_sigma=plane.measurement_sigma * factors[1],
        ins_error_sigma=plane.ins_error_sigma * factors[2], interval_s=interval_s,
        ins_error_time_constant_s=np.full(len(plane.channels), tau_s),
    )  # fmt: skip


def print_settings(settings: int, runs: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    planes = [read_aircraft(models_folder() / f"{axis}.json") for axis in AXES]
    wins = {pair: [] for pair in PAIRS}
    for k in range(settings):
        interval = np.exp(rng.uniform(np.log(0.02), np.log(0.2)))
        tau = np.exp(rng.uniform(np.log(5), np.log(300)))
        parts = []
        for i, plane in enumerate(planes):
            setting = random_setting(plane, rng, interval, tau)
            parts.append(compare(setting, runs, seed + 1000 + 2 * k + i, (PAPER, PAPER_NOW, OURS, OURS_LATE))[1])
        for (ours, theirs), won in wins.items():
            won.append(np.concatenate([r[ours].rmse(FAULT).mean(0) < r[theirs].rmse(FAULT).mean(0) for r in parts]))
    names = [c.name for p in planes for c in p.channels]
    for (ours, theirs), won in wins.items():
        share = ", ".join(f"{n} {s}" for n, s in zip(names, np.sum(won, axis=0)))
        print(
            f"{ours} better than {theirs} on all 8 channels in {np.all(won, axis=1).sum()} of {settings} settings; by channel: {share}"
        )


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m studies.ins_error_table", description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1000, help="flights for each aircraft and setting")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--settings", type=int, default=0, help="compare over so many random settings instead")
    o = parser.parse_args(arguments)
    if o.runs < 2:
        parser.error("--runs must be at least 2")
    print_settings(o.settings, o.runs, o.seed) if o.settings > 0 else print_comparison(o.runs, o.seed)


if __name__ == "__main__":
    main()
