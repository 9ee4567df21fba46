"""Truth, filters, errors and samples of a finished simulation, for plots and statistics.

The names by which truth and filters are known stand here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hnav.filters.filter_answers import HEALTH_SENSORS
from hnav.rotations import rotation_error_rad
from hnav.systems.results import Run
from hnav.systems.statistics import finite_mean, normalised_squares

TRUTH_ATTITUDE, TRUTH_FIELD = "truth.q", "truth.field"
SENSORS = {"accel": "force", "mag": "field"}
STATES = {
    "align.tilt_ready": "tilt ready",
    "align.heading_ready": "heading ready",
    "gate.accel_ok": "force in gate",
    "gate.mag_ok": "field in gate",
}


@dataclass(frozen=True)
class Estimate:
    """One attitude filter of a run beside the truth. Angles in rad, navigation axes; rows before its start are NaN."""

    run: Run
    name: str

    @cached_property
    def started(self) -> np.ndarray:
        return self.run[f"{self.name}.align.started"] > 0.5

    def vector(self, variable: str, size: int) -> np.ndarray:
        """n x size; NaN before the start."""
        return np.where(self.started[:, None], self.run.vector(self.name, variable, size), np.nan)

    @cached_property
    def q_nb(self) -> np.ndarray:
        return self.vector("att.q", 4)

    @cached_property
    def error_rad(self) -> np.ndarray | None:
        """Rotation vector from estimate to truth (n x 3); None in a run without truth."""
        truth = truth_q_nb(self.run)
        return None if truth is None else rotation_error_rad(self.q_nb, truth)

    @property
    def error_deg(self) -> np.ndarray:
        """As error_rad, in deg; NaN in a run without truth."""
        return np.full((len(self.run.t_s), 3), np.nan) if self.error_rad is None else np.degrees(self.error_rad)

    @cached_property
    def nees(self) -> np.ndarray | None:
        """e' P^-1 e of the attitude (n), expectation 3 (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2)."""
        terms = [(i, j) for i in range(3) for j in range(i, 3)]
        if self.error_rad is None or not self.run.has(self.name, *(f"cov.P[{i + 1},{j + 1}]" for i, j in terms)):
            return None
        P = np.empty((len(self.run.t_s), 3, 3))
        for i, j in terms:
            P[:, i, j] = P[:, j, i] = self.run[f"{self.name}.cov.P[{i + 1},{j + 1}]"]
        known = np.isfinite(self.error_rad).all(axis=1)
        values = np.full(len(P), np.nan)
        values[known] = normalised_squares(self.error_rad[known], P[known])
        return values

    @cached_property
    def health(self) -> np.ndarray | None:
        """n x 3: the states of gyro, accel and mag as indices of SENSOR_STATES; None in a run without them."""
        names = [f"health.{sensor}.state" for sensor in HEALTH_SENSORS]
        if not self.run.has(self.name, *names):
            return None
        return np.stack([self.run[f"{self.name}.{name}"] for name in names], axis=1).astype(np.uint8)

    def sampled(self, sensor: str) -> np.ndarray:
        """Rows at which a sample of the sensor (accel, mag) was used; its outputs are held between them."""
        used = self.run[f"{self.name}.count.{sensor}_used"]
        return np.flatnonzero(np.diff(used, prepend=0.0) > 0)

    def dimension(self, sensor: str) -> int:
        """Number of components of the innovation; a run without the covariance may state it."""
        sizes = self.run.about.get("innovation_dimensions", {})
        return int(sizes[sensor]) if sensor in sizes else sum(self.run.has(self.name, f"innov.{sensor}[{i}]") for i in (1, 2, 3))

    def ready_s(self, name: str) -> float:
        """Time of the first row with align.<name>; NaN if there is none."""
        rows = np.flatnonzero(self.run[f"{self.name}.{name}"] > 0.5)
        return float(self.run.t_s[rows[0]]) if len(rows) else np.nan


def truth_component(run: Run) -> str | None:
    return next((c for c in run.components if run.has(c, *(f"{TRUTH_ATTITUDE}[{i}]" for i in range(1, 5)))), None)


def truth_q_nb(run: Run) -> np.ndarray | None:
    """True attitude (n x 4, scalar first, body to navigation), None in a run without it."""
    component = truth_component(run)
    return None if component is None else run.vector(component, TRUTH_ATTITUDE, 4)


def estimates(run: Run) -> list[Estimate]:
    """The attitude filters of a run, in the order of the system."""
    return [Estimate(run, c) for c in run.components if run.has(c, "att.q[1]", "att.q[4]", "att.sigma[1]", "align.started")]


def magnetometer(run: Run) -> str | None:
    """The component that outputs the measured field."""
    return next((c for c in run.components if run.has(c, "mag.field[1]", "mag.field[2]", "mag.field[3]")), None)


def measured_field(run: Run) -> np.ndarray:
    """Samples of the magnetometer (k x 3, T, sensor axes); a held value counts once."""
    component = magnetometer(run)
    assert component is not None, "ask magnetometer(run) first"
    field = run.vector(component, "mag.field", 3)
    counter = f"{component}.mag.sample"
    return field[np.diff(run[counter], prepend=0.0) != 0] if counter in run.columns else field


@dataclass(frozen=True)
class Figures:
    """Summary of a filter: angles in deg, times in s, NaN for unknown figures."""

    rmse_deg: float
    heading_rmse_deg: float
    final_deg: float
    nees: float
    nis: dict[str, tuple[float, int]]  # mean and expectation
    tilt_ready_s: float
    heading_ready_s: float


def figures(estimate: Estimate) -> Figures:
    total, heading = np.linalg.norm(estimate.error_deg, axis=1), estimate.error_deg[:, 2]
    nis = {}
    for sensor, meaning in SENSORS.items():
        rows = estimate.sampled(sensor)
        nis[meaning] = (finite_mean(estimate.run[f"{estimate.name}.nis.{sensor}"][rows]), estimate.dimension(sensor))
    return Figures(
        rmse_deg=np.sqrt(finite_mean(total**2)), heading_rmse_deg=np.sqrt(finite_mean(heading**2)), final_deg=float(total[-1]),
        nees=np.nan if estimate.nees is None else finite_mean(estimate.nees), nis=nis,
        tilt_ready_s=estimate.ready_s("align.tilt_ready"), heading_ready_s=estimate.ready_s("align.heading_ready"),
    )  # fmt: skip
