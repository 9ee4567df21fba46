"""What both sides are given, made here and written in full: recordings with faults, vehicles and their satellites, plants and plans."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hnav.io.readers import read
from hnav.io.readers.broad import find_trials
from hnav.native.arrays import Array
from hnav.native.library import SENSORS
from studies.ins.motions import turned_on
from studies.ins.vehicles import vehicle
from studies.observer.events import GRAVITY, bounce, heat

INTERVAL_S, SAMPLES_N = 0.02, 1000
PLANS = Path(__file__).with_name("plans")
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


# --------------------------------------------------------------------------------------------- recordings


INERTIAL = [
    f"{name} ({unit})" for stem, unit in (("g", "rad/s"), ("a", "m/s2"), ("m", "uT")) for name in (stem + axis for axis in "xyz")
]
RATE_HZ = 100
CUT_S = 60.0
# As vehicle() has them: the gyrocompass has a given position.
STARTS_S = {"car": 120.0, "aircraft": 90.0, "ship": 120.0, "polar": 200.0}


def write(name: str, folder: Path) -> None:
    """The file of this name among those that scenarios speak of."""
    whole, _, suffix = name.rpartition(".")
    stem, _, rest = whole.partition("-")
    if suffix in ("toml", "py"):
        (folder / name).write_text((PLANS / name).read_text() if suffix == "toml" else PYTHON[stem])
    elif stem == "fmu":
        write_table(folder / name, *stamped(*rest.split("-")))
    elif stem in SAMPLES:
        columns, values = SAMPLES[stem]()
        write_table(folder / name, columns, values)
    elif stem in STARTS_S:
        sensors, satellites = start(stem)
        write_table(folder / name, *(satellites if rest == "gnss" else (["t_s", *INERTIAL[:6]], FAULTS[rest or "none"](sensors))))
    else:
        samples = tumbling() if stem == "tumbling" else trial(int(stem.removeprefix("trial")))
        write_table(folder / name, ["t_s", *INERTIAL], FAULTS[rest or "none"](samples))


def write_table(file: Path, columns: list[str], values: Array) -> None:
    """Numbers by the shortest text that has their bits; an empty cell for NaN."""
    lines = (",".join("" if number != number else repr(number) for number in row) for row in values.tolist())
    file.write_text("\n".join([",".join(columns), *lines]) + "\n")


def trials() -> dict[int, Path]:
    """The BROAD trials of BROAD_DIR; none if it is not set."""
    return find_trials(os.environ["BROAD_DIR"]) if os.environ.get("BROAD_DIR") else {}


def trial(number: int) -> Array:
    """The first minute of a trial."""
    data = read(trials()[number])
    arrays = (data.t_s, data.rate_b_rad_s, data.force_b_m_s2, 1e6 * data.needed("field_b_tesla"))
    return np.asarray(np.column_stack(arrays)[data.t_s < CUT_S])


@cache
def tumbling() -> Array:
    """A body that tumbles, rests in between, and meets a false field once; some fields and forces are missing."""
    rng, t = np.random.default_rng(7), np.arange(CUT_S * RATE_HZ) / RATE_HZ
    n, moving = len(t), np.where((t % 20 > 12) & (t % 20 < 16), 0.0, 1.0)[:, None]
    w = moving * np.stack([1.3 * np.sin(1.1 * t), 1.7 * np.cos(0.7 * t), 2.4 * np.sin(0.4 * t)], axis=1)
    attitude = turned_on(Rotation.from_euler("zx", [40, 20], degrees=True), Rotation.from_rotvec(w[:-1] / RATE_HZ))
    false_field = np.where((t > 0.6 * CUT_S) & (t < 0.7 * CUT_S), 15.0, 0.0)[:, None] * [0.3, 1.0, -0.5]
    acceleration = moving * np.stack([np.sin(3 * t), np.cos(4 * t), 0.5 * np.sin(5 * t)], axis=1)
    force = attitude.apply(acceleration - [0, 0, 9.81], inverse=True) + 0.03 * rng.normal(size=(n, 3))
    field = attitude.apply([20.0, 1.0, 45.0] + false_field, inverse=True) + 0.2 * rng.normal(size=(n, 3))
    rate = w + [0.01, -0.02, 0.005] + 0.003 * rng.normal(size=(n, 3))
    field[rng.random(n) < 0.1], force[rng.random(n) < 0.05] = np.nan, np.nan
    return np.asarray(np.column_stack([t, rate, force, field]))


@cache
def start(kind: str) -> tuple[Array, tuple[list[str], Array]]:
    """Rows of a vehicle's inertial sensors, and the table of its satellites."""
    samples, _ = vehicle(kind, "navigation" if kind == "polar" else "industrial", 3, STARTS_S[kind])
    valid_s, received_s, sensor, value = samples.aids.arrays()
    columns = ["t_s", "received_s", "vn", "ve", "vd", "lat_deg", "lon_deg", "alt_m"]
    # Of a fix both parts have one time.
    velocity, position = (sensor == SENSORS.index(kind) for kind in ("velocity", "position"))
    place = value[position, :3] * [180 / np.pi, 180 / np.pi, 1]
    table = np.column_stack([valid_s[velocity], received_s[velocity], value[velocity, :3], place])
    return np.column_stack([samples.t_s, samples.rate_b_rad_s, samples.force_b_m_s2]), (columns, table)


def stamped(kind: str, fault: str) -> tuple[list[str], Array]:
    """Inputs of an FMU that reads counters and stamps, delivered evenly whatever the stamps are."""
    rows = FAULTS[fault](tumbling() if kind == "tumbling" else start(kind)[0])
    time, stamps = np.arange(len(rows)) / RATE_HZ, rows[:, 0] - rows[0, 0]
    columns, parts = ["time"], [time.astype(float)]
    for place, (sensor, value, per) in enumerate((("gyro", "rate", 1), ("accel", "force", 1), ("mag", "field", 1e-6))):
        if 3 * place + 1 < rows.shape[1]:
            known = np.isfinite(rows[:, 3 * place + 1 : 3 * place + 4]).all(axis=1)
            columns += [f"{sensor}.{value}[{i}]" for i in (1, 2, 3)] + [f"{sensor}.sample", f"{sensor}.t_meas"]
            parts += [*np.nan_to_num(per * rows[:, 3 * place + 1 : 3 * place + 4]).T, np.cumsum(known).astype(float), stamps]
    if kind != "tumbling":
        fixes = start(kind)[1][1] - np.array([rows[0, 0]] * 2 + [0] * 6)
        at = np.searchsorted(fixes[:, 1], time, side="right")
        now = np.radians(fixes[np.maximum(at - 1, 0)])
        columns += ["gnss.latitude", "gnss.longitude", "gnss.height", *(f"gnssvel.velocity[{i}]" for i in (1, 2, 3))]
        parts += [now[:, 5], now[:, 6], *np.degrees(now[:, [7, 2, 3, 4]]).T]
        for sensor in ("gnss", "gnssvel"):
            columns += [f"{sensor}.sample", f"{sensor}.t_meas", f"{sensor}.valid"]
            parts += [at.astype(float), np.degrees(now[:, 0]), np.ones(len(at))]
    return columns, np.column_stack(parts)


# --------------------------------------------------------------------------------------------- faults, from a third of the rows on


def _in_rows(columns: slice | int, length: int | None, change: Callable[[Array], Array | float]) -> Callable[[Array], Array]:
    """So many rows, or all that follow, changed in these columns."""

    def fault(rows: Array) -> Array:
        rows, k = rows.copy(), len(rows) // 3
        met = slice(k, None if length is None else k + length)
        rows[met, columns] = change(rows[met, columns])
        return rows

    return fault


def _of_rows(order: Callable[[np.ndarray, int], np.ndarray]) -> Callable[[Array], Array]:
    return lambda rows: rows[order(np.arange(len(rows)), len(rows) // 3)]


FAULTS: dict[str, Callable[[Array], Array]] = {
    "none": lambda rows: rows,
    "spike": _in_rows(1, 1, lambda _: 34.9),
    "force_spike": _in_rows(slice(4, 7), 1, lambda _: 300.0),
    "stuck": _in_rows(slice(1, 4), 300, lambda rates: rates[0]),
    "zeros": _in_rows(slice(4, 7), 300, lambda _: 0.0),
    "nan": _in_rows(slice(1, 7), 50, lambda _: np.nan),
    "gap": _of_rows(lambda at, k: np.concatenate([at[:k], at[k + 300 :]])),
    "twice": _of_rows(lambda at, k: np.repeat(at, np.where((at >= k) & (at < k + 100), 2, 1))),
    "swapped": _of_rows(lambda at, k: np.where(abs(at - k) < 100, at ^ 1, at)),
    "ahead": _in_rows(0, 1, lambda t_s: t_s + 1e5),
    "clock_ahead": _in_rows(0, None, lambda t_s: t_s + 1000.0),
    "clock_back": _in_rows(0, None, lambda t_s: t_s - 5.0),
}
