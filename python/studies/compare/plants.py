"""Plants to observe: plans, two plants as functions in Python, and samples of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hnav.native.arrays import Array
from studies.observer.events import GRAVITY, bounce, heat

INTERVAL_S, SAMPLES_N = 0.02, 1000
_PLAN = '[sensor."{sensor}"]\nnoise = {noise}\ngate_nis = {gate}\n'
_STATE = '[state."{name}"]\nstart = {start}\nstart_sigma = {sigma}\nnoise = {noise}\nready_sigma = {ready}\n'


def _plan(sensor: str, noise: float, gate: float, **states: tuple[float, float, float, float]) -> str:
    """States: start, its sigma, noise, and the sigma below which it is ready."""
    words = ("start", "sigma", "noise", "ready")
    tables = (_STATE.format(name=name, **dict(zip(words, values))) for name, values in states.items())
    return _PLAN.format(sensor=sensor, noise=noise, gate=gate) + "".join(tables)


PLANS = {
    "bounce": _plan("h", 0.02, 0, h=(1, 0.05, 0, 0.1), v=(0, 0.3, 0.02, 0.5)),
    "pendulum": _plan("angle", 0.02, 10.8, angle=(0.5, 0.5, 0, 0.05), rate=(0, 0.5, 0.05, 0.2)),
    "tank": _plan("level", 0.01, 10.8, level=(1.5, 0.5, 0.01, 0.05)),
    "relay": _plan("T", 0.1, 0, T=(0, 0.3, 0.1, 0.2)),
}
PYTHON = {
    "tank": """import hnav
plant = hnav.Plant(lambda t, x, u, p: 0.1 - 0.15 * max(x[0], 0.0) ** 0.5, lambda t, x, u, p: x[0], states={"level": 1.0},
                   sensors=["level"])
""",
    "relay": """import hnav
plant = hnav.Plant(
    lambda t, x, u, p, q: (3 if q[0] else -3) - x, lambda t, x, u, p, q: x[0], states={"T": 0.0}, sensors=["T"], discrete={"on": 1.0},
    indicators=lambda t, x, u, p, q: 1 - x[0] if q[0] else x[0] + 1,
    event=lambda t, x, u, p, q: (x, [1 - q[0]] if (x[0] >= 1 if q[0] else x[0] <= -1) else q),
)
""",
}


def _samples(
    sensor: str, start: tuple[float, ...], step: Callable[[Array, float], None], noise: float
) -> tuple[list[str], Array]:
    """Times and samples of the first state, some missing and one outlier; step: integrates the state over a short time, in place."""
    rng, x, substeps, rows = np.random.default_rng(11), np.array([start]), 20, []
    for k in range(1, SAMPLES_N + 1):
        for _ in range(substeps):
            step(x, INTERVAL_S / substeps)
        rows.append([INTERVAL_S * k, x[0, 0] + noise * rng.standard_normal()])
    table = np.array(rows)
    table[rng.random(SAMPLES_N) < 0.05, 1] = np.nan
    table[SAMPLES_N // 2, 1] = x[0, 0] + 2.0
    return ["t_s", sensor], table


def _swing(x: Array, d: float) -> None:
    x[:, 1] -= d * (GRAVITY * np.sin(x[:, 0]) + 0.1 * x[:, 1])
    x[:, 0] += d * x[:, 1]


def _drain(x: Array, d: float) -> None:
    x += d * (0.1 - 0.15 * np.sqrt(x))


NO_NOISE = np.zeros((1, 2))
SAMPLES: dict[str, Callable[[], tuple[list[str], Array]]] = {
    "bounce": lambda: _samples("h", (1.0, 0.0), lambda x, d: bounce(x, d, NO_NOISE), 0.02),
    "pendulum": lambda: _samples("angle", (0.7, 0.0), _swing, 0.02),
    "tank": lambda: _samples("level", (1.0,), _drain, 0.01),
    "relay": lambda: _samples("T", (0.0, 1.0), lambda x, d: heat(x, d, NO_NOISE), 0.1),
}
