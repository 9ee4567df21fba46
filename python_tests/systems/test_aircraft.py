"""Aircraft model files and the simulator."""

import json

import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.filters.linear_model import LinearModel
from hnav.systems.aircraft import models_folder, read_aircraft
from twins.aircraft import model_of, simulate

LONGITUDINAL = models_folder() / "f4c_longitudinal.json"
LATERAL = models_folder() / "f4c_lateral.json"


@pytest.mark.parametrize(
    ("path", "modes"),
    [(LONGITUDINAL, [(1.411, 0.2575), (0.0774, 0.0921)]), (LATERAL, [(1.822, 0.088), (1 / 1.54, 1), (1 / 58, 1)])],
)
def test_the_modes_are_those_of_the_source(path, modes):
    values = np.linalg.eigvals(read_aircraft(path).A_1_s)
    for frequency, damping in modes:
        near = values[np.argmin(np.abs(np.abs(values) - frequency))]
        assert abs(near) == pytest.approx(frequency, rel=0.01)
        assert -near.real / abs(near) == pytest.approx(damping, abs=1e-3)


def test_model_files_name_their_source_and_assumptions():
    files = sorted(models_folder().glob("*.json"))
    assert files
    for path in files:
        data = json.loads(path.read_text())
        assert data["source"] and data["assumptions"]


def test_the_template_says_what_is_missing():
    with pytest.raises(HnavError, match="bravo_template.json: A_1_s is missing"):
        read_aircraft(models_folder() / "bravo_template.json")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (dict(A_1_s=None), "A_1_s is missing"),
        (dict(source=None), "source is missing"),
        (dict(A_1_s=[[1, 2], [3, 4]]), r"A_1_s has the shape \(2, 2\), expected \(4, 4\)"),
        (dict(A_1_s=np.diag([1.0, -1, -1, -1]).tolist()), "A_1_s is unstable: eigenvalue 1"),
        (dict(A_1_s=np.full((4, 4), np.nan).tolist()), "A_1_s is not finite"),
        (dict(B_1_s="none"), "B_1_s is no array of numbers"),
        (dict(measurement_sigma=[1, 1, -1, 1]), "measurement_sigma must be at least 0"),
        (dict(ins_error_time_constant_s=[60, 60, 0, 60]), "ins_error_time_constant_s must be above 0"),
        (dict(interval_s=0), "interval_s must be above 0"),
        (dict(states=[]), "states: 0 given"),
        (dict(states=[{"name": "u"}] * 4), "unit is missing"),
        (dict(faults=[{"channel": "alpha", "noise_factor": 2, "first_step": 0, "last_step": 1}]), "no channel alpha"),
    ],
)
def test_impossible_data_are_refused_with_the_reason(tmp_path, change, reason):
    path = tmp_path / "aircraft.json"
    path.write_text(json.dumps(json.loads(LONGITUDINAL.read_text()) | change))
    with pytest.raises(HnavError, match=reason):
        read_aircraft(path)


def test_a_file_that_is_no_model_is_refused(tmp_path):
    with pytest.raises(HnavError, match="No such file"):
        read_aircraft(tmp_path / "nothing.json")
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(HnavError, match="no JSON"):
        read_aircraft(tmp_path / "broken.json")


def test_a_seed_is_a_flight():
    aircraft = read_aircraft(LATERAL)
    a, b, c = (simulate(aircraft, 2, 30, seed) for seed in (1, 1, 2))
    assert np.array_equal(a.z, b.z) and not np.array_equal(a.z, c.z)


def test_the_simulated_errors_have_the_variances_and_the_memory_that_the_file_says():
    aircraft = read_aircraft(LONGITUDINAL)
    flight = simulate(aircraft, runs=2000, steps=160, seed=4)
    error = flight.z - flight.x
    variance = aircraft.ins_error_sigma**2 + (aircraft.measurement_sigma * flight.noise_factor[:, None]) ** 2
    assert np.allclose(error.var(axis=0), variance[:, 0], rtol=0.15)
    memory = np.mean(error[:, 20] * error[:, 10], axis=0) / aircraft.ins_error_sigma**2
    assert np.allclose(memory, np.exp(-1 / 60), atol=0.12)
    assert set(np.unique(flight.noise_factor)) == {1, 5, 8}


def test_exact_and_printed_discretisation_of_the_coloured_error():
    aircraft = read_aircraft(LATERAL)
    exact, printed = model_of(aircraft), model_of(aircraft, euler_colour=True)
    assert exact.An[0, 0] == np.exp(-0.1 / 60) and printed.An[0, 0] == 1 - 0.1 / 60
    continuous = LinearModel(
        A=aircraft.A_1_s, B=aircraft.B_1_s, H=np.eye(4), Qw=np.diag(aircraft.process_noise**2), Qv=exact.Qv, P0=exact.P0,
        An=-np.eye(4) / 60, QU=2 * exact.Lambda0 / 60, interval_s=0.1,
    ).discrete()  # fmt: skip
    sampled = model_of(aircraft, sampled_noise=False)
    for name in ("A", "B", "Qw", "An", "QU", "Lambda0"):
        assert np.allclose(getattr(sampled, name), getattr(continuous, name), rtol=1e-9, atol=1e-15), name
