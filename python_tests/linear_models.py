"""Linear models with coloured errors for tests: the aircraft of the model files, and one where nothing is square."""

import numpy as np

from hnav.filters.linear_model import LinearModel
from hnav.systems.aircraft import models_folder, read_aircraft
from twins.aircraft import model_of, simulate

AXES = ("f4c_longitudinal", "f4c_lateral")


def flight_of(axis: str, steps: int = 200):
    aircraft = read_aircraft(models_folder() / f"{axis}.json")
    flight = simulate(aircraft, runs=1, steps=steps, seed=3)
    return model_of(aircraft), flight.u, flight.z[0]


def odd_model(rng, interval_s=0.0) -> LinearModel:
    """Nothing square, nothing diagonal."""
    nx, nu, nz, nw, nl = 5, 2, 3, 4, 2

    def covariance(n):
        M = rng.normal(size=(n, n))
        return M @ M.T + 0.1 * np.eye(n)

    A = rng.normal(size=(nx, nx))
    An = np.array([[0.9, 0.05, 0], [0, 0.8, 0], [0.1, 0, 0.95]])
    if interval_s:
        A, An = A - 3 * np.eye(nx), An - 1.5 * np.eye(nz)
    else:
        A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    return LinearModel(
        A=A, B=rng.normal(size=(nx, nu)), G=rng.normal(size=(nx, nw)), H=rng.normal(size=(nz, nx)), An=An,
        Bn=rng.normal(size=(nz, nl)), Qw=covariance(nw), Qv=covariance(nz), QU=covariance(nl), P0=covariance(nx),
        x0=rng.normal(size=nx), interval_s=interval_s,
    )  # fmt: skip
