"""All questions by name, in the order in which they are asked: command lines of hnav, and FMUs through fmpy."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from studies.compare.recordings import CUT_S, FAULTS, PYTHON, STARTS_S, trials


@dataclass(frozen=True)
class Scenario:
    """Either the words of a command, {in} and {out} in the places of folders and {fmus} in that of a side's FMUs, or an FMU."""

    name: str
    words: tuple[str, ...] = ()
    answer: str = ""  # the file in {out}, or the folder, that the command writes
    fmu: str = ""  # fmi2/NAME; with its example input, or without inputs
    exchange: bool = False
    samples: str = ""  # instead of its example input a table in {in}, by counters and stamps
    stop_s: float = 10.0
    parameters: dict[str, str] = field(default_factory=dict)

    def inputs(self) -> list[str]:
        """Names of the files that have to be made for it."""
        return [word.removeprefix("{in}/") for word in (*self.words, self.samples) if word.startswith("{in}/")]


OPTIONS = {
    "ahrs": {
        "default": "", "closed_form": "solver=closed_form", "kl": "gamma_mode=kl start_sigma_heading_rad=0.5",
        "forward": "gyro_hold=forward start_samples=3", "late": "horizon_s=0.05", "ranges": "gyro_range_rad_s=2.5 accel_range_m_s2=11",
    },
    "hrekf": {
        "default": "", "adams": "solver=adams", "closed_form": "solver=closed_form", "euler": "solver=euler",
        "fixed": "gamma_mode=fixed gamma=0.3", "relative": "gamma_mode=relative", "kl": "gamma_mode=kl solver=closed_form",
        "adapting": "gamma_mode=kl adaptation=corrected", "gates": "accel_gate_nis=3 mag_gate_nis=3",
    },
}  # fmt: skip
CUT_TRIALS = (7, 31)  # in HDF5
FORMS = ("mdkf", "amdkf", "differenced", "augmented", "plain")
INS = ("--filter", "ins", "--preset")
SYSTEMS = {
    "turntable": (8, "nominal", "outliers", "gyro_drift", "iron_residual"), "navigation": (60, "nominal", "outage_30", "jump", "ship"),
    "gyrocompass": (150, "nominal", "swaying"), "aircraft": (20, ""), "filter": (10, ""), "observer": (20, ""),
}  # fmt: skip
FMUS = (
    "Ahrs", "Hrekf", "Ins", "Turntable", "ImuMagSensor", "Vehicle", "Gnss", "Baro", "Wheel", "Pendulum", "Observer",
    "AircraftInsLateral", "AircraftInsLongitudinal", "InsErrorFilterLateral", "InsErrorFilterLongitudinal",
)  # fmt: skip
SAMPLED = ("ImuMagSensor", "Gnss", "Baro", "Wheel")  # for Co-Simulation alone
UNREADABLE = ("twice", "swapped", "ahead", "clock_back")
"""Faults of time stamps that a recording may not have but devices produce: FMUs only."""
READABLE = [fault for fault in FAULTS if fault not in ("none", *UNREADABLE)]


def all_scenarios() -> Iterator[Scenario]:
    """Without recordings, only scenarios of simulated motion remain."""
    yield from _attitude()
    yield from _navigation()
    yield from _observer()
    yield from _fmus()
    for system, (stop_s, *names) in SYSTEMS.items():
        for name in names:
            words = ("simulate", system, "--stop", str(stop_s), "--out", "{out}/run", *(("--scenario", name) if name else ()))
            yield Scenario(f"system/{system}/{name or 'nominal'}", words, "run")


def _filter(name: str, recording: str, *words: str, options: str = "") -> Scenario:
    settings = (word for option in options.split() for word in ("--set", option))
    return Scenario(name, ("filter", recording, "--out", "{out}/run.parquet", *words, *settings), "run.parquet")


def _attitude() -> Iterator[Scenario]:
    for filter, known in OPTIONS.items():
        own = ("--filter", filter)
        for number, path in trials().items():
            yield _filter(f"{filter}/trial/{number:02d}", str(path), *own, options="solver=closed_form")
        for number in set(CUT_TRIALS) & trials().keys():
            yield _filter(f"{filter}/solver/trial/{number:02d}", f"{{in}}/trial{number}.csv", *own)
        for option, settings in known.items():
            yield _filter(f"{filter}/option/{option}", "{in}/tumbling.csv", *own, options=settings)
        yield _filter(f"{filter}/option/enu", "{in}/tumbling.csv", *own, "--frame", "enu")
        for engine in ("fmi2-cs", "fmi2-me", "fmi3-cs", "fmi3-me"):
            yield _filter(f"{filter}/engine/{engine}", "{in}/tumbling.csv", *own, "--engine", engine)
        yield from (_filter(f"{filter}/fault/{fault}", f"{{in}}/tumbling-{fault}.csv", *own) for fault in READABLE)
    yield _filter("hrekf/paper", "{in}/tumbling.csv", "--filter", "hrekf", "--preset", "paper")
    for solver in ("closed_form", "erkstep"):
        yield _filter(f"ahrs/smooth/{solver}", "{in}/tumbling.csv", "--smooth", options=f"solver={solver}")
    for number in set(CUT_TRIALS) & trials().keys():
        yield _filter(f"ahrs/smooth/trial/{number:02d}", f"{{in}}/trial{number}.csv", "--smooth")
    for name, recording in {"tumbling": "{in}/tumbling.csv", **{f"trial/{n:02d}": str(p) for n, p in trials().items()}}.items():
        yield Scenario(f"calibration/{name}", ("calibrate", recording, "--out", "{out}/iron.json"), "iron.json")


def _navigation() -> Iterator[Scenario]:
    closed_form = "solver=closed_form"
    for kind in ("car", "aircraft", "ship"):
        gnss = ("--gnss", f"{{in}}/{kind}-gnss.csv")
        yield _filter(f"ins/start/{kind}", f"{{in}}/{kind}.csv", *INS, "industrial", *gnss, options=closed_form)
    car = ("{in}/car.csv", *INS)
    satellites = ("--gnss", "{in}/car-gnss.csv")
    yield _filter("ins/solver/car", *car, "industrial", *satellites)
    yield _filter("ins/smooth/car", *car, "industrial", *satellites, "--smooth", options=closed_form)
    for preset in ("consumer", "tactical", "navigation"):
        yield _filter(f"ins/preset/{preset}", *car, preset, *satellites, options=closed_form)
    place = "start_place=given start_latitude_rad=1.3962634015954636 start_longitude_rad=0.5 start_height_m=50"
    still = " rest_velocity_noise_m_s=0.01"
    yield _filter("ins/gyrocompass", "{in}/polar.csv", *INS, "navigation", options=f"{closed_form} {place}{still}")
    for fault in READABLE:
        yield _filter(f"ins/fault/{fault}", f"{{in}}/car-{fault}.csv", *INS, "industrial", *satellites, options=closed_form)
    if folder := os.environ.get("HNAV_FLIGHT"):
        yield _filter("ins/flight", str(Path(folder) / "thor75.csv"), *INS, "consumer", options=closed_form)
        yield _filter("ins/flight/smooth", str(Path(folder) / "thor75.csv"), *INS, "consumer", "--smooth", options=closed_form)


def _observer() -> Iterator[Scenario]:
    plants = {"pendulum": "{fmus}/fmi2/Pendulum.fmu", **{name: f"{{in}}/{name}.py" for name in PYTHON}}
    if folder := os.environ.get("HNAV_PLANTS"):
        plants |= {f"bounce/fmi{version}": f"{folder}/fmi{version}/BouncingBall.fmu" for version in (2, 3)}
    for name, plant in plants.items():
        stem = name.partition("/")[0]
        words = ("observe", plant, "--plan", f"{{in}}/{stem}.toml", "--data", f"{{in}}/{stem}.csv", "--out", "{out}/run.csv")
        yield Scenario(f"observer/{name}", words, "run.csv")


def _fmus() -> Iterator[Scenario]:
    for name, motion in (("Ahrs", "tumbling"), ("Hrekf", "tumbling"), ("Ins", "car")):
        for fault in ("none", *UNREADABLE, "clock_ahead"):
            samples, stop_s = f"{{in}}/fmu-{motion}-{fault}.csv", STARTS_S.get(motion, CUT_S)
            by_counter = {"sampling_mode": "counter"}
            yield Scenario(f"fmu/fault/{name}/{fault}", (), "", f"fmi2/{name}", False, samples, stop_s, by_counter)
    for version in (2, 3):
        for name in FMUS:
            fmu = f"fmi{version}/{name}"
            yield Scenario(f"fmu/{fmu}/cs", fmu=fmu)
            if version == 2 and name not in SAMPLED:
                yield Scenario(f"fmu/{fmu}/me", fmu=fmu, exchange=True, stop_s=4.0)
        for axis in ("Lateral", "Longitudinal"):
            fmu = f"fmi{version}/InsErrorFilter{axis}"
            for form in FORMS:
                scaling = "none" if form in ("mdkf", "amdkf") else "hmm"
                yield Scenario(f"fmu/{fmu}/{form}", fmu=fmu, stop_s=30.0, parameters={"form": form, "noise_scaling": scaling})
