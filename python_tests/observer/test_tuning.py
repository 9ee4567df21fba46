"""Noises from a recording."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

import hnav
from command_line import hnav as command
from hnav.cli.observe import verdict_of
from hnav.filters.observer import Observer
from hnav.filters.observer_offsets import offsets
from hnav.filters.observer_tuning import AHEAD, tune
from observer.test_plan_files import TEXT

T_S = np.arange(1, 1501) * 0.05


@cache
def recording(seed=1, k=4.0):
    """A recording of the little plant: process noise 0.1 of v, sensor noise 0.02."""
    rng, x, seen = np.random.default_rng(seed), np.array([1.0, 0.0]), []
    for _ in T_S:
        for _ in range(10):
            middle = x + 0.0025 * np.array([x[1], -k * x[0] - 0.3 * x[1]])
            x = x + 0.005 * np.array([middle[1], -k * middle[0] - 0.3 * middle[1]]) + [0, 0.1 * np.sqrt(0.005) * rng.normal()]
        seen.append(x[0] + 0.02 * rng.normal())
    return np.array(seen)


def plan_of(fmu, sensor_noise=0.1, noise=0.5):
    plan = hnav.Plan(fmu).sensor("x", noise=sensor_noise)
    return plan.state("x", start_sigma=0.2).state("v", start_sigma=0.5, noise=noise)


def test_the_noises_of_a_simulation_are_found(little_fmu):
    y, trials = recording(), []
    tuned = tune(plan_of(little_fmu), T_S, {"x": y}, progress=trials.append)
    assert tuned.plan.sensors["x"].noise == pytest.approx(0.02, rel=0.1)
    assert tuned.plan.states["v"].noise == pytest.approx(0.1, rel=0.25)
    assert tuned.factors["sensor x"] == pytest.approx(0.2, rel=0.1) and tuned.plan.states["x"].noise == 0
    assert tuned.undetermined == () and 0.7 < tuned.ahead_nis["x"] < 1.5
    before, after = tuned.log_likelihood
    assert max(trials) - 1 < after and before < after - 1000
    assert np.nanmean(Observer(tuned.plan).run(T_S, {"x": y}).nis["x"]) == pytest.approx(1, abs=0.1)
    # Its own plan is left as it was.
    assert plan_of(little_fmu).sensors["x"].noise == 0.1


def test_a_model_holds_only_with_innovations_that_are_white_and_as_large_as_stated(little_fmu):
    tuned = tune(plan_of(little_fmu, 0.03, 0.15), T_S[:400], {"x": recording()[:400]})
    assert tuned.predictions["x"] == 30
    assert verdict_of(tuned.ahead_nis["x"], 30, tuned.correlation["x"], tuned.mean_nis["x"]).endswith("the model holds")
    for figures in ((3.6, 30, 0.0, 1.0), (0.08, 30, 0.0, 1.0), (1.1, 30, 0.3, 1.0), (1.1, 30, 0.0, 1.4), (1.1, 30, 0.0, 0.6)):
        assert verdict_of(*figures).endswith("the model is wrong, not only its noise")
    assert "too few samples" in verdict_of(np.nan, 0, 0.0, 1.0)


def test_a_mean_of_few_predictions_condemns_no_model_by_chance():
    """At most one mean in fifty of a correct model is outside the limits, for any number of predictions."""
    rng = np.random.default_rng(4)
    for n in (1, 5, 50):
        means = rng.chisquare(n, 400) / n
        wrong = sum("is wrong" in verdict_of(mean, n, 0.0, 1.0) for mean in means)
        assert wrong <= 0.02 * 400
    assert verdict_of(0.2, 5, 0.0, 1.0).endswith("holds") and "is wrong" in verdict_of(0.2, 50, 0.0, 1.0)


def test_the_likelihood_is_that_of_the_samples(little_fmu):
    """The log-likelihood of two samples, by their joint covariance."""
    plan, y = plan_of(little_fmu).sensor("y", noise=0.3), np.array([1.05, 0.9])
    run = Observer(plan).run([0.0], {"x": y[:1], "y": y[1:]})
    S = 0.04 + np.diag([0.01, 0.09])
    e = y - 1
    expected = -0.5 * (e @ np.linalg.solve(S, e) + np.log(np.linalg.det(2 * np.pi * S)))
    assert run.log_likelihood == pytest.approx([expected])
    assert np.isnan(Observer(plan).run([0.0, 1.0], {"x": [1.0, np.nan]}).log_likelihood[1])


def test_a_noise_that_the_samples_do_not_determine_is_named(little_fmu):
    plan = plan_of(little_fmu, 0.02, 0.1).unknown_input("d", start_sigma=1e-9, noise=1e-9)
    tuned = tune(plan, T_S[:300], {"x": recording()[:300]})
    assert "unknown_input d" in tuned.undetermined


def test_a_wrong_model_is_distinguished_from_its_noise(little_fmu):
    plan = plan_of(little_fmu, 0.02, 0.1)
    t_s, samples = T_S[:400], {"x": recording()[:400]}
    wrong = tune(plan.copy().set("k", 9.0), t_s, samples)
    assert np.isfinite(wrong.ahead_nis["x"]) and AHEAD == 10
    right = tune(plan, t_s, samples)
    assert right.log_likelihood[1] > wrong.log_likelihood[1] + 100


def test_offsets_are_found_once_and_what_follows_contradicts_nothing(little_fmu):
    y, rng = recording()[:500], np.random.default_rng(2)
    samples = {"x": y, "other": y + 0.5 + 0.02 * rng.normal(size=500)}
    plan = plan_of(little_fmu, 0.05, 0.2).sensor("other", of="x", noise=0.05, offset=0.2)
    tuned = tune(plan, T_S[:500], samples)
    assert tuned.offsets["other"] - tuned.offsets.get("x", 0) == pytest.approx(-0.5, abs=0.02)
    assert tuned.plan.sensors["other"].offset == tuned.plan.sensors["other"].own_offset == tuned.offsets["other"]
    assert tuned.plan.sensors["other"].noise < 0.05
    again = tune(tuned.plan, T_S[:500], samples)
    assert again.offsets == {} and again.log_likelihood[1] == pytest.approx(tuned.log_likelihood[1], abs=1)
    assert all(factor == pytest.approx(1, abs=0.1) for factor in again.factors.values())


def test_an_offset_that_following_does_not_confirm_is_not_named(little_fmu):
    y = recording()[:200] + 0.3  # a spring whose rest is known
    plan = plan_of(little_fmu, 0.02, 0.1)
    run = Observer(plan).run(T_S[:200], {"x": y})
    asked = []
    for answer in (None, run):
        assert offsets(run, plan, lambda changed, answer=answer: (asked.append(changed), answer)[1]) == {}
    assert [one.sensors["x"].own_offset < 0 for one in asked] == [True, True]


def test_a_plan_without_noise_is_refused(little_fmu):
    with pytest.raises(hnav.HnavValueError, match="no state has noise"):
        tune(plan_of(little_fmu, noise=0), T_S, {"x": recording()})
    with pytest.raises(hnav.HnavValueError, match="the plan itself has no likelihood"):
        tune(plan_of(little_fmu), T_S[::-1], {"x": recording()})


def test_noises_on_the_command_line(little_fmu, tmp_path):
    plan, data = tmp_path / "plan.toml", tmp_path / "data.csv"
    plan.write_text(TEXT)
    pd.DataFrame({"t_s": T_S[:600], "x": recording()[:600]}).to_csv(data, index=False)
    printed = command("observe", little_fmu, "--plan", plan, "--data", data, "--tune")
    assert printed.returncode == 0, printed.stderr
    assert '[sensor."x"]\nnoise = 0.0' in printed.stdout and '[state."v"]\nnoise = 0.' in printed.stdout
    assert "predicted over 10 samples: mean NIS" in printed.stdout and "the model holds" in printed.stdout
    assert command("observe", little_fmu, "--plan", plan, "--tune").returncode == 2
