"""Attitude filters by the C API: recordings in batches, made motion sample by sample with all that may happen between."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.compare.inputs import Samples
from studies.compare.native import Log, Object, Options
from studies.compare.scenario import Arrays, Named, Settings, Source, given, made, of_trial
from studies.compare.side import Side

CHUNK = 1000  # rows of a batch after which everything else is read too
HEADING_EVERY, HEADING_SIGMA_RAD = 100, 0.03
INNOVATING = {"accel": 1, "mag": 2, "heading": 3}
OUTPUTS = {
    "q_nb": 4, "euler_rad": 3, "sigma_rad": 3, "gyro_bias_rad_s": 3, "gyro_bias_sigma_rad_s": 3, "accel_nis": 1,
    "mag_nis": 1,
}  # fmt: skip
SOLVERS = ("erkstep", "adams", "closed_form", "euler")
GAMMA_MODES = ("off", "fixed", "relative", "kl")
MOUNTED: Settings = {"navigation_frame": "enu", "declination_rad": 0.1, "q_body_sensor": [0.8, 0.1, -0.3, 0.2]}


def open_filter(side: Side, filter: str, preset: str = "default", **settings: Any) -> Object:
    options = Options(side.library, filter, preset, **settings)
    return Object(side.library, "filter", f"hnav_{filter}_create", options.struct)


# --------------------------------------------------------------------------------------------- what is read


class Reader:
    """Everything that a filter tells, noted row after row in structs that are made once."""

    def __init__(self, target: Object):
        self.target, self.log = target, Log(target.library)
        argument = target.library.argument
        self._structs = {name: argument(f"hnav_filter_{name}", 1) for name in ("attitude", "posterior", "field", "diagnostics")}
        self._innovation = argument("hnav_filter_innovation", 2)
        self._arrays: dict[str, list[NDArray[Any]]] = {
            "rate": [np.zeros(3)],
            "covariance": [np.zeros((6, 6))],
            "gyro_bias": [np.zeros(3), np.zeros(3)],
        }
        self._arrays["gyro_calibration"] = [np.zeros((3, 3)), np.zeros((3, 3))]
        self._pointers = {name: [target.library.pointer(a) for a in arrays] for name, arrays in self._arrays.items()}

    def note(self) -> None:
        """A call that is refused leaves what was there, so its status is noted too."""
        target, log = self.target, self.log
        for name, struct in self._structs.items():
            log.add(f"{name}.status", target.status(name, struct))
            log.struct(name, struct)
        for sensor, number in INNOVATING.items():
            log.add(f"innovation.{sensor}.status", target.status("innovation", number, self._innovation))
            log.struct(f"innovation.{sensor}", self._innovation)
        for name, arrays in self._arrays.items():
            log.add(f"{name}.status", target.status(name, *self._pointers[name]))
            for i, array in enumerate(arrays):
                log.add(f"{name}.{i}", array.copy())


def batch(target: Object, samples: Samples, call: str = "run", chunk: int = CHUNK) -> Arrays:
    """hnav_filter_run or _smooth over all rows; between the chunks of a run everything else is read."""
    n, library, reader = len(samples.t_s), target.library, Reader(target)
    outputs: Arrays = {name: np.full((n, width), np.nan) for name, width in OUTPUTS.items()}
    outputs["ready"] = np.zeros((n, 2), np.uint8)
    statuses = []
    for first in range(0, n, chunk):
        rows = slice(first, min(first + chunk, n))
        arrays_in, arrays_out = library.argument(f"hnav_filter_{call}", 2), library.argument(f"hnav_filter_{call}", 3)
        inputs = {"t_s": samples.t_s, "rate_b_rad_s": samples.rate, "force_b_m_s2": samples.force, "field_b_tesla": samples.field}
        library.assign(arrays_in, {name: values[rows] for name, values in inputs.items()})
        library.assign(arrays_out, {name: values[rows] for name, values in outputs.items()})
        more = [library.ffi.NULL] if call == "run" else []
        statuses.append(target.status(call, rows.stop - rows.start, arrays_in, arrays_out, *more))
        if call == "run":
            reader.note()
    return outputs | {"status": np.array(statuses)} | reader.log.columns()


def recorded(
    side: Side, filter: str, source: Source, call: str = "run", chunk: int = CHUNK, preset: str = "default", **settings: Any
) -> Arrays:
    return batch(open_filter(side, filter, preset, **settings), source(side), call, chunk)


# --------------------------------------------------------------------------------------------- sample by sample


class Stepper:
    """Pushes the samples of row after row and advances, notes everything after each row."""

    def __init__(self, target: Object, samples: Samples):
        self.target, self.samples, self.reader = target, samples, Reader(target)
        pointer = target.library.pointer
        n = len(samples.t_s)
        self._present = {name: np.isfinite(getattr(samples, name)).all(axis=1) for name in ("rate", "force", "field")}
        self._rows = {name: [pointer(getattr(samples, name)[i]) for i in range(n)] for name in self._present}

    def push(self, i: int, sensor: str, name: str, t_s: float) -> None:
        if self._present[name][i]:
            self.reader.log.add(f"push_{sensor}.status", self.target.status(f"push_{sensor}", t_s, self._rows[name][i]))

    def row(self, i: int, heading: bool = False) -> None:
        t_s = float(self.samples.t_s[i])
        self.push(i, "gyro", "rate", t_s)
        self.push(i, "accel", "force", t_s)
        self.push(i, "mag", "field", t_s)
        if heading and i % HEADING_EVERY == HEADING_EVERY // 2:
            status = self.target.status("push_heading", t_s, float(self.samples.heading[i]), HEADING_SIGMA_RAD)
            self.reader.log.add("push_heading.status", status)
        self.advance(t_s)

    def advance(self, t_s: float) -> None:
        self.reader.log.add("advance.status", self.target.status("advance", t_s))
        self.reader.note()

    def columns(self) -> Arrays:
        return self.reader.log.columns()


def stepwise(side: Side, filter: str, source: Source, heading: bool = False, **settings: Any) -> Arrays:
    samples = source(side)
    stepper = Stepper(open_filter(side, filter, **settings), samples)
    for i in range(len(samples.t_s)):
        stepper.row(i, heading)
    return stepper.columns()


def between_samples(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    """Looks ahead between samples too, and the clock of the caller need not be that of the samples."""
    samples = source(side)
    stepper = Stepper(open_filter(side, filter, **settings), samples)
    for i, t_s in enumerate(samples.t_s.tolist()):
        stepper.row(i)
        if i % 3 == 0:
            stepper.advance(t_s + 0.0037)
    return stepper.columns()


def late_fields(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    """Fields arrive 40 ms and more after they were measured, some of them too late for the horizon."""
    samples = source(side)
    stepper = Stepper(open_filter(side, filter, horizon_s=0.1, queue_capacity=256, **settings), samples)
    times, rng = samples.t_s.tolist(), np.random.default_rng(11)
    arrivals: dict[int, list[int]] = {}
    for i in range(len(times)):
        arrivals.setdefault(i + int(rng.choice([4, 5, 9, 14], p=[0.5, 0.3, 0.18, 0.02])), []).append(i)
    for i, t_s in enumerate(times):
        stepper.push(i, "gyro", "rate", t_s)
        stepper.push(i, "accel", "force", t_s)
        for k in arrivals.get(i, []):
            stepper.push(k, "mag", "field", times[k])
        stepper.advance(t_s)
    return stepper.columns()


def saved_and_loaded(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    """Every second and a bit the filter is saved with samples waiting, and another one goes on."""
    samples = source(side)
    stepper, found = Stepper(open_filter(side, filter, horizon_s=0.05, **settings), samples), Arrays()
    for i in range(len(samples.t_s)):
        if i % 130 == 100:
            state = stepper.target.save()
            found = _joined(found, stepper.columns())
            stepper = Stepper(open_filter(side, filter, horizon_s=0.05, **settings), samples)
            stepper.target.load(state)
        stepper.row(i)
    return _joined(found, stepper.columns())


def _joined(first: Arrays, second: Arrays) -> Arrays:
    return {name: np.concatenate([first[name], second[name]]) if name in first else second[name] for name in second} | {
        name: values for name, values in first.items() if name not in second
    }


def started_anew(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    """realign after a third, reset after two thirds."""
    samples = source(side)
    stepper, n = Stepper(open_filter(side, filter, **settings), samples), len(samples.t_s)
    for i in range(n):
        if i in (n // 3, 2 * n // 3):
            stepper.target.call("realign" if i == n // 3 else "reset")
            stepper.reader.note()
        stepper.row(i)
    return stepper.columns()


def refused_samples(side: Side, filter: str, source: Source, **settings: Any) -> Arrays:
    """Zero vectors, infinities, times that run backwards, late samples, a full queue."""
    samples, zero = source(side), np.zeros(3)
    stepper = Stepper(open_filter(side, filter, queue_capacity=16, **settings), samples)
    target, pointer = stepper.target, stepper.target.library.pointer
    wrong = {"push_accel": zero, "push_mag": zero, "push_gyro": np.array([np.inf, 0, 0])}
    for i, t_s in enumerate(samples.t_s.tolist()):
        if i % 50 == 49:
            for call, value in wrong.items():
                stepper.reader.log.add(f"{call}.refusal", target.status(call, t_s, pointer(value)))
            stepper.reader.log.add("late.refusal", target.status("push_mag", t_s - 0.5, pointer(samples.field[i])))
            stepper.reader.log.add("backwards.refusal", target.status("advance", t_s - 1))
            stepper.reader.log.add("time.refusal", target.status("advance", np.nan))
        if i % 200 == 150:
            for k in range(20):
                status = target.status("push_gyro", t_s + 1e-4 * k, pointer(samples.rate[i]))
                stepper.reader.log.add("full.refusal", status)
        stepper.row(i)
    return stepper.columns()


# --------------------------------------------------------------------------------------------- the list


def scenarios(trials: list[int]) -> Iterator[Named]:
    for filter in ("ahrs", "hrekf"):
        for number in trials:
            yield f"c/{filter}/trial/{number:02d}", given(recorded, filter, of_trial(number), navigation_frame="enu")
        yield from _variants(filter, trials)
        yield from _happenings(filter)
    yield from _smoothers(trials)


COMMON_VARIANTS: dict[str, Settings] = {
    "hold_forward": {"gyro_hold": "forward"},
    "hold_backward": {"gyro_hold": "backward"},
    "start_attitude": {"start_mode": "attitude", "start_q_nb": [0.9, 0.1, 0.2, 0.3], "start_sigma_heading_rad": 0.4},
    "start_heading": {"start_mode": "heading", "start_heading_rad": 1.1},
    "start_mean": {"start_samples": 7},
    "reference_given": {"reference_mode": "given", "reference_strength_tesla": 4.9e-5, "reference_dip_rad": 1.15},
}
AHRS_VARIANTS: dict[str, Settings] = {
    **{f"solver_{s}": {"solver": s} for s in SOLVERS},
    **{f"gamma_{g}": {"gamma_mode": g, "start_sigma_heading_rad": 0.5} for g in GAMMA_MODES},
    "euler_coarse": {"solver": "euler", "euler_step_s": 0.002},
    "tolerances": {"solver_rtol": 1e-4, "solver_atol": 1e-5},
    "frames": MOUNTED,
    **COMMON_VARIANTS,
    "latency": {"output_latency_s": 0.02},
    "evidence": {"trust_s": 5.0, "candidate_first_s": 1.0, "ready_evidence_s": 2.0, "mag_gate": 2.0},
    "noise": {"gyro_noise_rad_per_sqrt_s": 1e-3, "velocity_noise_m_s_per_sqrt_hz": 0.3, "heading_gate_nis": 3.0},
}
PRECISE: Settings = {
    "gyro_noise_rad_per_sqrt_s": 1e-3, "gyro_bias_walk_rad_s_per_sqrt_s": 1e-4, "accel_noise_per_sqrt_hz": 5e-4,
    "mag_noise_per_sqrt_hz": 5e-4, "start_sigma_bias_rad_s": 0.05, "accel_gate_nis": 13.9, "mag_gate_nis": 13.9,
}  # fmt: skip
HREKF_VARIANTS: dict[str, Settings] = {
    **{f"{g}_{s}": {"gamma_mode": g, "solver": s} for g in GAMMA_MODES for s in SOLVERS},
    **{f"paper_{g}_{s}": {"preset": "paper", "gamma_mode": g, "solver": s} for g in GAMMA_MODES for s in SOLVERS},
    **{f"adaptation_{a}": {"adaptation": a, **PRECISE} for a in ("off", "paper", "corrected")},
    "adaptation_kl": {"adaptation": "corrected", "gamma_mode": "kl", "adaptation_gain": 0.1},
    "adaptation_bounds": {
        "adaptation": "corrected", "adaptation_min_rad_s_per_sqrt_s": 1e-5, "adaptation_max_rad_s_per_sqrt_s": 1e-4,
    },
    "tight_gates": {"accel_gate_nis": 3.0, "mag_gate_nis": 3.0, "heading_gate_nis": 2.0},
    "weights": {"gamma_mode": "kl", "gamma_weight_bias": 0.1, "gamma_weight_attitude": 0.7},
    "quaternion_noise": {"quaternion_noise_per_sqrt_s": 1e-3},
    "frames": MOUNTED | {"gamma_mode": "relative"},
    **COMMON_VARIANTS,
    "interval": {"max_interval_s": 0.002},
}  # fmt: skip
VARIANTS = {"ahrs": AHRS_VARIANTS, "hrekf": HREKF_VARIANTS}
CROPS = {7: (5.0, 35.0), 31: (40.0, 60.0)}  # trial: seconds


def _variants(filter: str, trials: list[int]) -> Iterator[Named]:
    for name, settings in VARIANTS[filter].items():
        yield f"c/{filter}/made/{name}", given(recorded, filter, made(40), chunk=50, **settings)
        for number, (start_s, stop_s) in CROPS.items():
            if number in trials:
                crop = of_trial(number, start_s, stop_s)
                yield f"c/{filter}/crop/{number:02d}/{name}", given(recorded, filter, crop, chunk=200, **settings)


def _happenings(filter: str) -> Iterator[Named]:
    drivers = {
        "steps": stepwise, "between": between_samples, "late": late_fields, "save_load": saved_and_loaded,
        "realign_reset": started_anew, "refused": refused_samples,
    }  # fmt: skip
    settings: dict[str, Settings] = {"default": {}, "closed_form": {"solver": "closed_form"}, "kl": {"gamma_mode": "kl"}}
    if filter == "hrekf":
        settings["adapting"] = {"adaptation": "corrected", "gamma_mode": "relative"}
    for name, driver in drivers.items():
        for label, chosen in settings.items():
            yield f"c/{filter}/{name}/{label}", given(driver, filter, made(12), **chosen)
    for label, chosen in settings.items():
        yield f"c/{filter}/heading/{label}", given(stepwise, filter, made(20, gaps=False), heading=True, **chosen)
    no_field = {"start_field_wait_s": 1.0} if filter == "ahrs" else {}
    yield f"c/{filter}/heading/without_field", given(stepwise, filter, made(10, field=False), heading=True, **no_field)


def _smoothers(trials: list[int]) -> Iterator[Named]:
    whole: Settings = {"call": "smooth", "chunk": 10**9}
    settings: dict[str, Settings] = {"default": {}, "closed_form": {"solver": "closed_form"}, "frames": MOUNTED}
    for label, chosen in settings.items():
        yield f"c/ahrs/smooth/made/{label}", given(recorded, "ahrs", made(40), **whole, **chosen)
    for number in trials:
        yield f"c/ahrs/smooth/{number:02d}", given(recorded, "ahrs", of_trial(number, 0, 60), navigation_frame="enu", **whole)
    yield "c/hrekf/smooth", given(recorded, "hrekf", made(3), **whole)
