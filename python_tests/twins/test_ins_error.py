"""The filter for coloured INS errors again in NumPy: the library agrees with it in every form and setting."""

import itertools

import numpy as np
import pytest

from hnav.filters.ins_error import FORMS, NOISE_SCALINGS, OUTPUTS, InsErrorFilter, InsErrorOptions
from linear_models import AXES, flight_of, odd_model
from twins.ins_error import run_reference

SETTINGS = [
    dict(form=form, noise_scaling=scaling, lag=lag)
    for form, scaling, lag in itertools.product(FORMS, NOISE_SCALINGS, (0, 1))
    if form not in ("mdkf", "amdkf") or (scaling, lag) == ("none", 0)
]


def worst(run, reference) -> dict[str, float]:
    """Largest difference of each output, in units of its own size."""
    out = {}
    for name in OUTPUTS:
        a, b = getattr(run, name), getattr(reference, name)
        assert np.array_equal(np.isnan(a), np.isnan(b)), name
        if np.isfinite(b).any():
            out[name] = np.nanmax(np.abs(a - b)) / max(1.0, np.nanmax(np.abs(b)))
    return out


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: " ".join(map(str, s.values())))
def test_the_library_is_the_numpy_reference(axis, setting):
    model, u, z = flight_of(axis)
    options = InsErrorOptions(**setting)
    difference = worst(InsErrorFilter(model, options).run(u, z), run_reference(model, options, u, z))
    assert max(difference.values()) < 1e-10, difference


@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: " ".join(map(str, s.values())))
def test_the_library_is_the_numpy_reference_with_missing_channels(setting):
    model, u, z = flight_of("f4c_longitudinal", 80)
    z = np.where(np.random.default_rng(1).random(z.shape) < 0.3, np.nan, z)
    z[20:24] = np.nan
    options = InsErrorOptions(**setting, window=5)
    difference = worst(InsErrorFilter(model, options).run(u, z), run_reference(model, options, u, z))
    assert max(difference.values()) < 1e-10, difference


@pytest.mark.parametrize("interval_s", [0, 0.05])
@pytest.mark.parametrize("form", FORMS)
def test_the_library_is_the_numpy_reference_on_full_matrices(form, interval_s):
    rng = np.random.default_rng(4)
    model = odd_model(rng, interval_s)
    u, z = rng.normal(size=(60, 2)), rng.normal(size=(60, 3))
    z[10, 1] = z[30] = np.nan
    for lag in (0, 1):
        options = InsErrorOptions(form=form, noise_scaling="none", window=8, lag=lag)
        difference = worst(InsErrorFilter(model, options).run(u, z), run_reference(model, options, u, z))
        assert max(difference.values()) < 1e-10, difference
