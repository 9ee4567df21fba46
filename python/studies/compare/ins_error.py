"""Coloured INS errors by the C API: every form and noise scaling on flights of the F-4C and on a model of full matrices."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from studies.compare.native import Log, Object, Options
from studies.compare.old_revision import TOP
from studies.compare.scenario import Arrays, Named, Settings, given
from studies.compare.side import Side

FORMS = ("mdkf", "amdkf", "differenced", "augmented", "plain")
SCALINGS = ("none", "paper_match", "gated_match", "hmm")
PRINTED = ("mdkf", "amdkf")
STEPS = 300
Model = dict[str, Any]  # the fields of hnav_ins_error_model


def aircraft_data(axis: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((TOP / "models/aircraft" / f"f4c_{axis}.json").read_text())
    return data


def aircraft_model(axis: str, continuous: bool = False) -> Model:
    data = aircraft_data(axis)
    A, B, dt = np.array(data["A_1_s"]), np.array(data["B_1_s"]), data["interval_s"]
    n, m = B.shape
    tau, lambda_sigma = np.array(data["ins_error_time_constant_s"], float), np.array(data["ins_error_sigma"])
    Qw = np.diag(np.square(data["process_noise_per_sqrt_s"]))
    common = {
        "H": np.eye(n), "Qv": np.diag(np.square(data["measurement_sigma"])), "P0": np.diag(np.square(data["start_sigma"])),
    }  # fmt: skip
    sizes = {"nx": n, "nu": m, "nz": n, "nw": n, "nl": n}
    if continuous:
        colour = {"An": np.diag(-1 / tau), "QU": np.diag(2 / tau * lambda_sigma**2)}
        return sizes | common | colour | {"interval_s": dt, "A": A, "B": B, "Qw": Qw}
    held = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * dt)
    phi, Lambda0 = np.exp(-dt / tau), np.diag(lambda_sigma**2)
    colour = {"An": np.diag(phi), "QU": Lambda0 @ np.diag(1 - phi**2), "Lambda0": Lambda0}
    discrete = {"A": np.ascontiguousarray(held[:n, :n]), "B": np.ascontiguousarray(held[:n, n:]), "Qw": Qw * dt}
    return sizes | common | colour | discrete


def full_model(seed: int = 3) -> Model:
    """Three states, two channels, nothing diagonal but Qv."""
    rng = np.random.default_rng(seed)

    def covariance(n: int) -> NDArray[Any]:
        root = rng.normal(size=(n, n))
        return root @ root.T + 0.1 * np.eye(n)

    nx, nu, nz, nw, nl = 3, 1, 2, 2, 3
    A, An = rng.normal(size=(nx, nx)), rng.normal(size=(nz, nz))
    return {
        "nx": nx, "nu": nu, "nz": nz, "nw": nw, "nl": nl, "A": 0.9 * A / np.abs(np.linalg.eigvals(A)).max(),
        "An": 0.8 * An / np.abs(np.linalg.eigvals(An)).max(), "B": rng.normal(size=(nx, nu)), "G": rng.normal(size=(nx, nw)),
        "H": rng.normal(size=(nz, nx)), "Bn": rng.normal(size=(nz, nl)), "Qw": covariance(nw), "Qv": np.diag([0.3, 0.5]),
        "QU": covariance(nl), "x0": rng.normal(size=nx), "P0": covariance(nx),
    }  # fmt: skip


def flight(model: Model, steps: int = STEPS, seed: int = 1) -> tuple[NDArray[Any], NDArray[Any]]:
    """u (steps x nu) and z (steps x nz): noise around what the controls do, with a channel that is bad for a while."""
    rng = np.random.default_rng(seed)
    nx, nu, nz = (model[name] for name in ("nx", "nu", "nz"))
    u = 0.02 * np.sign(np.sin(2 * np.pi * np.arange(steps)[:, None] / [60 + 10 * i for i in range(nu)] + 0.1))
    A, B = model["A"], model["B"]
    if model.get("interval_s"):
        A, B = np.eye(nx) + model["interval_s"] * A, model["interval_s"] * B
    sigma = np.sqrt(np.diag(model["Qv"]))
    x, colour, z = np.zeros(nx), np.zeros(nz), np.empty((steps, nz))
    for k in range(steps):
        x = A @ x + B @ u[k] + 0.01 * rng.normal(size=nx)
        colour = 0.98 * colour + 0.3 * sigma * rng.normal(size=nz)
        factor = np.where((np.arange(nz) == nz - 1) & (100 <= k < 150), 6.0, 1.0)
        z[k] = model["H"] @ x + colour + factor * sigma * rng.normal(size=nz)
    return np.ascontiguousarray(u), z


def with_missing(z: NDArray[Any], seed: int = 2) -> NDArray[Any]:
    rng = np.random.default_rng(seed)
    z = np.where(rng.random(z.shape) < 0.15, np.nan, z)
    z[40:44] = np.nan
    return z


# --------------------------------------------------------------------------------------------- drivers


def model_struct(side: Side, model: Model) -> Any:
    struct = side.library.argument("hnav_ins_error_filter_create", 2)
    side.library.assign(struct, model)
    return struct


def open_filter(side: Side, model: Model, **settings: Any) -> Object:
    options = Options(side.library, "ins_error", **settings)
    return Object(side.library, "ins_error_filter", "hnav_ins_error_filter_create", options.struct, model_struct(side, model))


class Reader:
    """Everything that the filter tells after a step."""

    def __init__(self, target: Object, model: Model):
        nx, nz = model["nx"], model["nz"]
        self._target, self.log = target, Log(target.library)
        self._info = target.library.argument("hnav_ins_error_filter_info", 1)
        self._shapes: dict[str, list[tuple[int, ...]]] = {
            "estimate": [(nx,), (nx,)], "covariance": [(nx, nx)], "coloured_error": [(nz,)] * 3,
            "innovation": [(nz,), (nz, nz), (1,)], "noise": [(nz,), (nz,)], "separability": [(1,)],
        }  # fmt: skip

    def note(self) -> None:
        target = self._target
        for name, shapes in self._shapes.items():
            arrays = [np.zeros(shape) for shape in shapes]
            self.log.add(f"{name}.status", target.status(name, *map(target.library.pointer, arrays)))
            for i, array in enumerate(arrays):
                self.log.add(f"{name}.{i}", array)
        self.log.add("info.status", target.status("info", self._info))
        self.log.struct("info", self._info)


def batch(side: Side, model: Model, z: NDArray[Any], u: NDArray[Any], **settings: Any) -> Arrays:
    target, library, n = open_filter(side, model, **settings), side.library, len(z)
    nx, nz = model["nx"], model["nz"]
    outputs: Arrays = {name: np.full((n, nz), np.nan) for name in ("lambda", "lambda_sigma", "compensated", "innovation")}
    outputs |= {name: np.full((n, nz), np.nan) for name in ("noise_scale", "fault_probability")}
    outputs |= {"x": np.full((n, nx), np.nan), "sigma": np.full((n, nx), np.nan)}
    outputs |= {"covariance": np.full((n, nx, nx), np.nan), "nis": np.full(n, np.nan)}
    arrays_in, arrays_out = (library.argument("hnav_ins_error_filter_run", i) for i in (2, 3))
    library.assign(arrays_in, {"u": u, "z": z})
    library.assign(arrays_out, outputs)
    status = target.status("run", n, arrays_in, arrays_out, library.ffi.NULL)
    return outputs | {"status": np.array([status]), "warning": np.array([target.text("warning")])}


def stepwise(side: Side, model: Model, z: NDArray[Any], u: NDArray[Any], other: Model | None = None, **settings: Any) -> Arrays:
    """Step after step by a mask of what is present; saved and loaded after a third, reset after two thirds, from the middle
    on with the matrices of the other model."""
    library, n = side.library, len(z)
    target = open_filter(side, model, **settings)
    reader = Reader(target, model)
    present = np.ascontiguousarray(np.isfinite(z), np.uint8)
    filled = np.nan_to_num(z)
    parts = []
    for k in range(n):
        if k == n // 3:
            state = target.save()
            parts.append(reader.log.columns())
            target = open_filter(side, model, **settings)
            target.load(state)
            reader = Reader(target, model)
        if k == n // 2 and other is not None:
            target.call("replace_model", model_struct(side, other))
        if k == 2 * n // 3:
            target.call("reset")
        reader.log.add("step.status", target.status("step", *map(library.pointer, (u[k], filled[k], present[k]))))
        reader.note()
    parts.append(reader.log.columns())
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


# --------------------------------------------------------------------------------------------- the list


def settings_of() -> Iterator[tuple[str, Settings]]:
    for form, scaling in product(FORMS, SCALINGS):
        if form not in PRINTED or scaling == "none":
            yield f"{form}_{scaling}", {"form": form, "noise_scaling": scaling}
    for form in ("differenced", "augmented", "plain"):
        yield f"{form}_lag", {"form": form, "lag": 1, "noise_scaling": "none"}
        yield f"{form}_standard", {"form": form, "joseph": 0, "noise_scaling": "none"}
    yield "augmented_lag_hmm", {"lag": 1, "noise_scaling": "hmm", "joseph": 0, "hmm_levels": 5, "hmm_level_ratio": 3.0}
    yield "augmented_window", {"noise_scaling": "gated_match", "window": 11, "gate_alpha": 0.01}
    yield "amdkf_window", {"form": "amdkf", "noise_scaling": "none", "window": 9}


def models() -> dict[str, Model]:
    return {
        "lateral": aircraft_model("lateral"), "longitudinal": aircraft_model("longitudinal"),
        "continuous": aircraft_model("longitudinal", continuous=True), "full": full_model(),
    }  # fmt: skip


def scenarios() -> Iterator[Named]:
    for label, model in models().items():
        u, z = flight(model)
        for name, settings in settings_of():
            yield f"c/ins_error/run/{label}/{name}", given(batch, model, z, u, **settings)
            yield f"c/ins_error/missing/{label}/{name}", given(batch, model, with_missing(z), u, **settings)
    model, other = full_model(), full_model(4)
    u, z = flight(model)
    for name, settings in settings_of():
        yield f"c/ins_error/steps/{name}", given(stepwise, model, with_missing(z), u, other, **settings)
