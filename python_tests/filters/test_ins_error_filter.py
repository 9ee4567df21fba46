"""The filter for coloured INS errors from Python: laws, exact covariances, and the errors that a caller gets."""

from dataclasses import replace

import numpy as np
import pytest

from hnav.errors import HnavError
from hnav.filters.ins_error import FORMS, OUTPUTS, InsErrorFilter, InsErrorOptions
from hnav.filters.linear_model import LinearModel
from hnav.native.options import option_rows
from hnav.systems.aircraft import models_folder, read_aircraft
from linear_models import AXES, flight_of, odd_model
from twins.aircraft import model_of, simulate


@pytest.mark.parametrize("form", FORMS)
def test_matrices_may_change_between_steps(form):
    rng = np.random.default_rng(5)
    models = [odd_model(np.random.default_rng(5 + k % 2)) for k in range(20)]
    options = InsErrorOptions(form=form, noise_scaling="none")
    f, x = InsErrorFilter(models[0], options), []
    for model in models:
        f.replace_model(model)
        f.step(rng.normal(size=2), rng.normal(size=3))
        x.append(f.estimate()[0])
    once = InsErrorFilter(models[0], options)
    for _ in range(2):
        rng = np.random.default_rng(5)
        for model, expected in zip(models, x):
            once.replace_model(model)
            once.step(rng.normal(size=2), rng.normal(size=3))
            assert np.array_equal(once.estimate()[0], expected)
        once.replace_model(models[0])
        once.reset()
    assert not np.allclose(x[-1], InsErrorFilter(models[0], options).run(np.zeros((20, 2)), np.zeros((20, 3))).x[-1])


def test_run_is_step_after_step_to_the_last_bit():
    model, u, z = flight_of("f4c_lateral", 50)
    run, f = InsErrorFilter(model).run(u, z), InsErrorFilter(model)
    for k in range(len(z)):
        f.step(u[k], z[k])
        x, sigma = f.estimate()
        lam, lam_sigma, compensated = f.coloured_error()
        nu, _, nis = f.innovation()
        scale, fault = f.noise()
        shown = (x, sigma, f.covariance(), lam, lam_sigma, compensated, nu, nis, scale, fault)
        assert all(np.array_equal(a, getattr(run, name)[k]) for a, name in zip(shown, OUTPUTS))


def test_a_mask_is_the_same_as_nan():
    model, u, z = flight_of("f4c_lateral", 50)
    present = np.random.default_rng(2).random(z.shape) > 0.2
    masked, missing = InsErrorFilter(model).run(u, z, present), InsErrorFilter(model).run(u, np.where(present, z, np.nan))
    assert all(np.array_equal(getattr(masked, n), getattr(missing, n), equal_nan=True) for n in OUTPUTS)


def test_a_saved_filter_goes_on_with_the_same_bits():
    model, u, z = flight_of("f4c_longitudinal", 150)
    f = InsErrorFilter(model)
    f.run(u[:90], z[:90])
    state = f.save()
    tail = f.run(u[90:], z[90:])
    other = InsErrorFilter(model)
    other.load(state)
    again = other.run(u[90:], z[90:])
    assert all(np.array_equal(getattr(tail, n), getattr(again, n)) for n in OUTPUTS)
    with pytest.raises(HnavError, match="its model or options differ"):
        InsErrorFilter(model, InsErrorOptions(gate_alpha=0.01)).load(state)


def test_the_lateral_model_warns_that_spiral_and_colour_separate_poorly():
    lateral = InsErrorFilter(flight_of("f4c_lateral", 1)[0])
    assert lateral.separability() < 0.1 and "separate poorly" in lateral.warning
    longitudinal = InsErrorFilter(flight_of("f4c_longitudinal", 1)[0])
    assert longitudinal.separability() > 0.1 and longitudinal.warning == ""


def test_options_are_described_and_checked_by_name():
    for name, info in option_rows("ins_error").items():
        assert info.description and getattr(InsErrorOptions(), name) is not None
    with pytest.raises(HnavError, match="form = kalman: choose one of mdkf"):
        InsErrorOptions(form="kalman")
    with pytest.raises(HnavError, match="no option windows; did you mean window"):
        InsErrorOptions(windows=3)


def test_a_matrix_of_the_wrong_shape_is_named():
    eye = np.eye(2)
    with pytest.raises(HnavError, match=r"Qv has the shape \(3, 3\), expected \(2, 2\)"):
        LinearModel(A=eye, H=eye, Qw=eye, Qv=np.eye(3), P0=eye)
    with pytest.raises(HnavError, match="z has the shape"):
        InsErrorFilter(LinearModel(A=0.5 * eye, H=eye, Qw=eye, Qv=eye, P0=eye)).step(None, np.zeros(3))


def powers(M: np.ndarray, count: int) -> np.ndarray:
    """count x n x n, from the zeroth on."""
    found = np.empty((count, *M.shape))
    found[0] = np.eye(len(M))
    for k in range(1, count):
        found[k] = M @ found[k - 1]
    return found


def true_covariance(model: LinearModel, options: InsErrorOptions, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Exact covariance of the settled filter's error, and the one it claims.

    A settled filter without adaptation is linear, so the error is the sum of its responses to every past noise: one unit
    impulse of each noise goes through the model and then through the library, and the squares of the errors add up (the
    series solution of the Lyapunov equation). Nothing of the filter but its answers is used.
    """
    m = model.discrete()
    f = InsErrorFilter(model, options)
    f.run(np.zeros((steps, m.nu)), np.zeros((steps, m.nz)))  # settles at zero, as slowly as the slowest mode
    settled = f.save()
    late = options.form in ("mdkf", "amdkf") or options.lag == 1
    total, of_A, of_An = np.zeros((m.nx, m.nx)), powers(m.A, steps - 1), powers(m.An, steps - 1)
    for source, Q in (("w", m.Qw), ("U", m.QU), ("v", m.Qv)):
        assert np.array_equal(Q, np.diag(np.diag(Q)))
        for i, variance in enumerate(np.diag(Q)):
            unit = np.eye(len(Q))[i]
            x, lam, z = np.zeros((steps, m.nx)), np.zeros((steps, m.nz)), np.zeros((steps, m.nz))
            if source == "w":
                x[1:] = of_A @ (m.G @ unit)
            elif source == "U":
                lam[1:] = of_An @ (m.Bn @ unit)
            z = x @ m.H.T + lam
            z[1] += unit * (source == "v")
            f.load(settled)
            estimate = f.run(np.zeros((steps, m.nu)), z).x
            error = estimate[1:] - x[:-1] if late else estimate - x
            total += variance * error.T @ error
    f.load(settled)
    return total, f.covariance()


EXACT = {
    "augmented": (1, dict(form="augmented")),
    "augmented, lag 1": (1, dict(form="augmented", lag=1)),
    "augmented without white noise": (0, dict(form="augmented")),
    "differenced without white noise": (0, dict(form="differenced")),
    "differenced without white noise, lag 1": (0, dict(form="differenced", lag=1)),
}


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", EXACT)
def test_the_exact_covariance_is_the_claimed_one(axis, name):
    white, setting = EXACT[name]
    model = flight_of(axis, 1)[0]
    model = replace(model, Qv=white * model.Qv)
    true, claimed = true_covariance(model, InsErrorOptions(**setting, noise_scaling="none"), 12000)
    sigma = np.sqrt(np.diag(claimed))
    assert np.abs((true - claimed) / np.outer(sigma, sigma)).max() < 1e-6


@pytest.mark.parametrize("axis", AXES)
def test_the_printed_filter_claims_another_covariance_than_it_has_and_the_augmented_one_is_better(axis):
    model = flight_of(axis, 1)[0]
    true, claimed = true_covariance(model, InsErrorOptions(form="mdkf"), 12000)
    best, _ = true_covariance(model, InsErrorOptions(noise_scaling="none", lag=1), 12000)  # uses the same samples
    assert np.abs(np.diag(true) / np.diag(claimed) - 1).max() > 0.2
    assert (np.diag(best) < np.diag(true)).all()


def test_the_noise_scale_of_the_paper_is_above_one_in_healthy_channels():
    """max(1, S_ii) has the mean 1 + 1/sqrt(pi M): it is why AMDKF loses to MDKF where nothing is faulty."""
    aircraft = read_aircraft(models_folder() / "f4c_lateral.json")
    flight = simulate(aircraft, runs=40, steps=200, seed=5)
    f = InsErrorFilter(model_of(aircraft), InsErrorOptions(form="amdkf", window=20))
    scales = []
    for z in flight.z:
        f.reset()
        scales.append(f.run(flight.u, z).noise_scale[30:])
    assert np.mean(scales) == pytest.approx(1 + 1 / np.sqrt(np.pi * 20), abs=0.06)


def jumping_flight() -> tuple[LinearModel, np.ndarray, np.ndarray]:
    """A flight of the F-4C whose error of roll jumps and whose sideslip is noisy for a while, with samples missing."""
    model, u, z = flight_of("f4c_lateral", 200)
    z = z.copy()
    z[60:, 3] += 10 * np.sqrt(model.Qv[3, 3])
    z[100:140, 0] += 6 * np.sqrt(model.Qv[0, 0]) * np.random.default_rng(2).normal(size=40)
    z[::17, 1] = np.nan
    return model, u, z


FAULTS = ("fault_probability", "bias_fault_probability", "process_fault_probability")


def test_kinds_of_fault_are_distinguished():
    model, u, z = jumping_flight()
    f = InsErrorFilter(model)
    run = f.run(u, z)
    assert run.bias_fault_probability[60:75, 3].max() > 0.9 and run.bias_fault_probability[:, :3].max() < 0.5
    assert np.median(run.fault_probability[110:140, 0]) > 0.9 and run.fault_probability[:100, 0].max() < 0.5
    assert run.fault_probability[80:, 3].max() < 0.5 and np.median(run.process_fault_probability) < 0.1
    for probability, last in zip(f.faults(), (run.fault_probability, run.bias_fault_probability, run.process_fault_probability)):
        np.testing.assert_array_equal(probability, last[-1])


def test_faults_do_not_hang_on_units_or_on_the_order_of_channels():
    model, u, z = jumping_flight()
    straight = InsErrorFilter(model).run(u, z)
    unit, order = np.array([1e-3, 7.0, 1e4, 0.2]), np.array([2, 0, 3, 1])
    T = np.diag(unit)[order]  # of the measurements
    Ti = np.linalg.inv(T)
    covariances = {name: T @ getattr(model, name) @ T.T for name in ("Qv", "QU", "Lambda0")}
    other = replace(model, H=T @ model.H, An=T @ model.matrix("An") @ Ti, Bn=np.eye(4), **covariances)
    turned = InsErrorFilter(other).run(u, (z * unit)[:, order])
    size = np.abs(straight.x).max(axis=0)
    np.testing.assert_allclose(turned.x / size, straight.x / size, rtol=0, atol=1e-7)
    for name in FAULTS:
        before = getattr(straight, name)
        np.testing.assert_allclose(getattr(turned, name), before[:, order] if before.ndim > 1 else before, rtol=0, atol=1e-6)


@pytest.mark.parametrize("scaling", ["none", "gated_match", "hmm"])
def test_what_no_hypothesis_judges_has_no_fault(scaling):
    model, u, z = jumping_flight()
    run = InsErrorFilter(model, noise_scaling=scaling).run(u, z)
    assert not run.bias_fault_probability.any() and not run.process_fault_probability.any()
