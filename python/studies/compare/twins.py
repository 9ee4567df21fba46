"""The Python of each side: its NumPy twins of the filters, and whole systems by its own master."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from studies.compare.attitude import PRECISE
from studies.compare.ins_error import Model, flight, models, settings_of, with_missing
from studies.compare.native import option_rows
from studies.compare.scenario import Arrays, Named, Settings, Source, given, made, of_trial
from studies.compare.side import Side

HREKF_SETTINGS: dict[str, Settings] = {
    "hekf": {}, "fixed": {"gamma_mode": "fixed", "gamma": 0.3}, "relative": {"gamma_mode": "relative"}, "kl": {"gamma_mode": "kl"},
    "weighted": {"gamma_mode": "kl", "gamma_weight_bias": 0.1}, "adaptation_paper": {"adaptation": "paper", "adaptation_gain": 0.1},
    "adaptation_corrected": {"adaptation": "corrected"}, "backward": {"gyro_hold": "backward"},
    "tight_gates": {"accel_gate_nis": 3, "mag_gate_nis": 3}, "noise_on_q": {"quaternion_noise_per_sqrt_s": 1e-3},
    "frames": {"navigation_frame": "enu", "declination_rad": 0.1, "q_body_sensor": [0.8, 0.1, -0.3, 0.2]},
    "given_field": {"start_samples": 3, "reference_mode": "given", "reference_strength_tesla": 4.9e-5, "reference_dip_rad": 1.15},
}  # fmt: skip


def hrekf(side: Side, source: Source, **settings: Any) -> Arrays:
    samples = source(side)
    names = option_rows(side.library, "hrekf")
    chosen = {side.names.find("option", name, names): value for name, value in (PRECISE | settings).items()}
    options = side.module("hnav.filters.attitude").Options("hrekf", **chosen)
    run = side.module("hnav.reference.hrekf").run_reference(samples.t_s, samples.rate, samples.force, samples.field, options)
    return dict(zip(("q_nb", "gyro_bias", "sigma"), run))


def ins_error(side: Side, model: Model, **settings: Any) -> Arrays:
    u, z = flight(model)
    wrapper = side.module("hnav.filters.ins_error")
    fields = {name: value for name, value in model.items() if isinstance(value, np.ndarray) or name == "interval_s"}
    options = wrapper.InsErrorOptions(**settings)
    run = side.module("hnav.reference.ins_error").run_reference(wrapper.LinearModel(**fields), options, u, with_missing(z))
    return {name: np.asarray(values, float) for name, values in vars(run).items()}


def system(side: Side, name: str, stop_s: float | None = None, seed: int | None = None, **chosen: str) -> Arrays:
    """Everything that the components of a system put out; the names of components and variables are the new ones."""
    run = side.module("hnav.systems.simulation").simulate(name, seed=seed, stop_s=stop_s, record=("*",), **chosen)
    found: Arrays = {"t_s": run.t_s, "failure": np.array(run.about["failure"])}
    for full, values in run.columns.items():
        component, _, variable = full.partition(".")
        found[f"{side.names.canonical('component', component)}.{side.names.canonical('variable', variable)}"] = values
    return found


SCENARIOS = (
    "nominal", "gyro_drift", "outliers", "magnetic_disturbance", "iron_residual", "matched", "fitted", "fitted_rho_half",
    "fitted_honest",
)  # fmt: skip


def scenarios(trials: list[int]) -> Iterator[Named]:
    for name, settings in HREKF_SETTINGS.items():
        yield f"twin/hrekf/{name}", given(hrekf, made(1, gaps=False), **settings)
    if 7 in trials:
        yield "twin/hrekf/trial/07", given(hrekf, of_trial(7, 20, 21))
    for label, model in models().items():
        for name, settings in settings_of():
            yield f"twin/ins_error/{label}/{name}", given(ins_error, model, **settings)
    for scenario in SCENARIOS:
        yield f"system/turntable/{scenario}", given(system, "turntable", 20, scenario=scenario)
    for grade in ("consumer", "industrial", "tactical"):
        yield f"system/turntable/grade/{grade}", given(system, "turntable", 10, grade=grade)
    yield "system/turntable", given(system, "turntable")
    for seed in (1, 2):
        yield f"system/turntable/seed/{seed}", given(system, "turntable", 10, seed)
        yield f"system/aircraft/seed/{seed}", given(system, "aircraft", None, seed)
    yield "system/aircraft", given(system, "aircraft")
    yield "system/filter", given(system, "filter", 5)
