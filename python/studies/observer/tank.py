"""A tank that runs empty, where its plant has no answer, and is filled again: is it found again, and is it ready only where it follows?"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hnav.filters.observer import Observer
from hnav.filters.observer_plan import Plan
from hnav.filters.plant import Plant
from hnav.native.arrays import Array

DT, NOISE, DRIVE = 0.5, 0.02, 0.01
T_S = np.arange(DT, 120.5, DT)
INFLOW = np.where((T_S > 40) & (T_S < 70), 0.0, 0.3)  # before each instant
REFILLED = T_S > 75


def tank() -> Plant:
    """h' = q - 0.15 sqrt(h), which has no answer below 0."""
    return Plant(
        states={"h": 1.0}, inputs={"q": 0.3}, sensors=["h"],
        derivatives=lambda t, x, u, p: [u[0] - 0.15 * (math.sqrt(x[0]) if x[0] >= 0 else math.nan)],
        outputs=lambda t, x, u, p: [x[0]],
    )  # fmt: skip


def plan(**bounds: float) -> Plan:
    """What is known of it."""
    return Plan(tank()).sensor("h", noise=NOISE).input("q").state("h", start_sigma=0.3, ready_sigma=0.1, noise=DRIVE, **bounds)


def emptied(seed: int) -> tuple[Array, Array]:
    """Truth and samples."""
    rng = np.random.default_rng(seed)
    h, steps, levels = max(1 + 0.3 * rng.normal(), 0.05), 50, []
    drive = DRIVE * math.sqrt(DT / steps) * rng.normal(size=(len(INFLOW), steps))
    for q, row in zip(INFLOW.tolist(), drive.tolist()):
        for push in row:
            h = max(h + DT / steps * (q - 0.15 * math.sqrt(h)) + push, 0.0)
        levels.append(h)
    return np.array(levels), np.array(levels) + NOISE * rng.normal(size=len(T_S))


def inflow() -> Array:
    """An input holds from its sample on."""
    return np.append(INFLOW[1:], INFLOW[-1])


def followed(observer: Observer, y: Array) -> tuple[Array, Array]:
    """Rows of estimate, sigma and ready, and of intervals held and instants dropped so far."""
    rows, counts = list[tuple[float, float, bool]](), list[tuple[int, int]]()
    for t, q, sample in zip(T_S, inflow(), y):
        observer.push_input("q", t, q)
        observer.push("h", t, sample)
        observer.advance(t)
        x, sigma = observer.estimate()
        info = observer.info()
        rows.append((x["h"], sigma["h"], info.ready))
        counts.append((info.held, info.dropped))
    return np.array(rows), np.array(counts)


def measured(name: str, runs: int, **bounds: float) -> dict[str, Any]:
    """One plan. found: runs whose error is within 3 sigma in at least 95 % of the samples after the tank is refilled; nees: of
    these samples; held, dropped: intervals and instants, of all runs; ready_meanwhile: instants at which it was ready although
    the interval before was held or the sample dropped; ready: percent of the instants after the tank is refilled; negative:
    estimates below 0."""
    found, squares, totals, meanwhile, ready, negative = 0, [], np.zeros(2, int), 0, [], 0
    for seed in range(runs):
        h, y = emptied(seed)
        rows, counts = followed(Observer(plan(**bounds)), y)
        error = (rows[:, 0] - h)[REFILLED] / rows[REFILLED, 1]
        found += bool(np.mean(np.abs(error) < 3) >= 0.95)
        squares.append(np.mean(error**2))
        totals += counts[-1]
        missing = np.diff(counts, axis=0, prepend=0).any(axis=1)
        meanwhile += int(rows[missing, 2].sum())
        ready.append(rows[REFILLED, 2].mean())
        negative += int((rows[:, 0] < 0).sum())
    return {
        "plan": name, "runs": runs, "found": found, "nees": np.mean(squares), "held": totals[0], "dropped": totals[1],
        "ready_meanwhile": meanwhile, "ready": 100 * np.mean(ready), "negative": negative,
    }  # fmt: skip


def results(runs: int = 100) -> list[dict[str, Any]]:
    """Without and with a bound."""
    return [measured("no bound", runs), measured("min = 0", runs, min=0.0)]
