"""Twins: the C library and every FMU flavour on the same samples."""

import numpy as np
import pytest

from attitude_twins import PRECISE, difference
from hnav import Filter, Options
from hnav.filters.options import FILTERS
from hnav.fmi.engines import ENGINES, run_recording
from hnav.fmi.fmu_run import filter_parameters
from hnav.fmi.fmus import Fmu, fmu_path
from hnav.io.readers import read
from hnav.reports.scores import score

OFF_DEFAULT = {
    "hrekf": {k: str(v) for k, v in PRECISE.items()} | {"gamma_mode": "kl", "adaptation": "corrected"},
    "ahrs": {"gamma_mode": "relative", "start_sigma_heading_rad": "0.5", "gyro_hold": "forward"},
}


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("engine", [e for e in ENGINES if e.endswith("cs")])
def test_co_simulation_is_the_library_bit_for_bit(engine, filter, motion):
    settings = OFF_DEFAULT[filter]
    c = run_recording(motion.recording, filter, "c", settings=settings)
    fmu = run_recording(motion.recording, filter, engine, settings=settings)
    for name in ("q_nb", "sigma_rad", "gyro_bias_rad_s", "gyro_bias_sigma_rad_s"):
        assert np.array_equal(getattr(c, name), getattr(fmu, name), equal_nan=True), name
    assert np.array_equal(c.ready, fmu.ready)
    assert fmu.counts["rhs_evals"] > 0  # SUNDIALS did the work
    assert fmu.counts["accel_used"] == c.counts["accel_used"] == len(motion.recording.t_s)


def rates_in_fmu(version: int, settings: dict[str, str], m) -> list[float]:
    """hinf.decay_rate of Hrekf in Co-Simulation, after the samples of every row of m."""
    rates = []
    with Fmu(fmu_path("Hrekf", version)) as fmu:
        for name, value in filter_parameters("hrekf", settings, "default").items():
            fmu.set(name, value)
        fmu.initialise()
        for k, row in enumerate(zip(m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla)):
            for (prefix, variable), sample in zip((("gyro", "gyro.rate"), ("accel", "accel.force"), ("mag", "mag.field")), row):
                for axis in range(3):
                    fmu.set(f"{variable}[{axis + 1}]", sample[axis])
                fmu.set(f"{prefix}.t_meas", m.t_s[k])
                fmu.set(f"{prefix}.sample", k + 1)
            fmu.do_step(float(m.t_s[k]), 0.01)
            rates.append(fmu.get("hinf.decay_rate"))
    return rates


@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("gamma_mode", ("off", "relative", "kl"))
def test_the_decay_rate_of_the_fmu_is_that_of_the_library_number_by_number(version, gamma_mode, motion):
    m, settings = motion.recording.cropped(1), {"gamma_mode": gamma_mode}
    in_c, expected = Filter(Options("hrekf", **settings)), []
    for t_s, rate, force, field in zip(m.t_s.tolist(), m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla):
        in_c.push_gyro(t_s, rate)
        in_c.push_accel(t_s, force)
        in_c.push_mag(t_s, field)
        in_c.advance(t_s)
        expected.append(in_c.diagnostics().decay_rate_1_s)
    assert rates_in_fmu(version, settings, m) == expected
    assert sum(rate != 0 for rate in expected) > 90


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("engine", [e for e in ENGINES if e.endswith("me")])
def test_model_exchange_agrees_to_a_millionth(engine, filter, motion):
    """By fmpy's CVODE at a relative tolerance of 1e-8, rates up to 10 rad/s."""
    m = motion.recording.cropped(1)
    c = run_recording(m, filter, "c")
    fmu = run_recording(m, filter, engine)
    assert difference(c.q_nb, fmu.q_nb) < 1e-6
    assert np.nanmax(np.abs(c.gyro_bias_rad_s - fmu.gyro_bias_rad_s)) < 1e-6
    assert np.nanmax(np.abs(c.sigma_rad - fmu.sigma_rad)) < 1e-6


@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("engine", ENGINES)
def test_every_engine_gives_the_same_score_on_a_real_recording(engine, filter, broad_trial):
    """30 s of a BROAD trial; 12 s in Model Exchange, which integrates step by step."""
    crop = broad_trial.cropped(12 if engine.endswith("me") else 30)
    settings = {"navigation_frame": "enu"}
    s, expected = (score(run_recording(crop, filter, e, settings=settings).q_nb, crop.reference_q_nb) for e in (engine, "c"))
    assert s.total < 10
    if engine.endswith("me"):
        assert s.total == pytest.approx(expected.total, abs=1e-3)
    else:
        assert s == expected


@pytest.mark.slow
@pytest.mark.parametrize("filter", FILTERS)
@pytest.mark.parametrize("engine", [e for e in ENGINES if e != "c"])
def test_every_engine_agrees_on_whole_recordings(engine, filter, broad_trials):
    """Co-Simulation bit for bit. In Model Exchange a rounding may open a gate one sample earlier: equal scores."""
    settings = {"navigation_frame": "enu"}
    for path in broad_trials.values():
        trial = read(path)
        c, fmu = (run_recording(trial, filter, e, settings=settings) for e in ("c", engine))
        if engine.endswith("cs"):
            assert np.array_equal(c.q_nb, fmu.q_nb, equal_nan=True), trial.name
        expected, found = (score(r.q_nb, trial.reference_q_nb, trial.movement) for r in (c, fmu))
        assert found.total == pytest.approx(expected.total, abs=0.01), trial.name
