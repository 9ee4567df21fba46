"""Hybrid navigation filters: attitude and heading from gyroscope, accelerometer and magnetometer, with their uncertainty.

    import hnav

    recording = hnav.read("walk.csv")
    run = hnav.Filter("ahrs").run(recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla)
    run.to_dataframe()
    run.report("walk.html", recording)

filters     attitude and heading, navigation, linear models with coloured INS errors, observers of any model, magnetometer calibration
simulation  plants and sensors that drive filters
io          recordings of real sensors
fmi         the same filters as FMUs
systems     systems of FMUs, closed simulation, many runs of them
reports     errors, pictures and pages
certify     proofs of stability of a run
reference   the filters again in NumPy, slow and readable
native      the C library by its headers
errors      what can go wrong; units: names of units
cli         the command line

What is named here is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from hnav.errors import HnavError, HnavRuntimeError, HnavValueError, PlausibilityWarning, UnknownOptionError

if TYPE_CHECKING:
    from hnav.filters.attitude import Filter
    from hnav.filters.attitude_answers import Run
    from hnav.filters.calibration import MagnetometerCalibration, calibrate_magnetometer
    from hnav.filters.declination import declination_rad
    from hnav.filters.ins import Ins
    from hnav.filters.ins_aids import Aids
    from hnav.filters.ins_answers import InsRun
    from hnav.filters.ins_error import InsErrorFilter, InsErrorOptions, InsErrorRun
    from hnav.filters.linear_model import LinearModel
    from hnav.filters.observer import Observer, ObserverOptions, ObserverRun
    from hnav.filters.observer_plan import Plan, read_plan
    from hnav.filters.options import Options
    from hnav.filters.plant import Plant
    from hnav.io.readers import read
    from hnav.io.recordings import Recording
    from hnav.io.sensors import read_grade, write_sensor
    from hnav.reports.runs import plot_run, report_run

__version__ = "0.2.0"
__all__ = [
    "Aids",
    "Filter",
    "HnavError",
    "HnavRuntimeError",
    "HnavValueError",
    "Ins",
    "InsErrorFilter",
    "InsErrorOptions",
    "InsErrorRun",
    "InsRun",
    "LinearModel",
    "MagnetometerCalibration",
    "Observer",
    "ObserverOptions",
    "ObserverRun",
    "Options",
    "Plan",
    "Plant",
    "PlausibilityWarning",
    "Recording",
    "Run",
    "UnknownOptionError",
    "__version__",
    "calibrate_magnetometer",
    "declination_rad",
    "plot_run",
    "read",
    "read_grade",
    "read_plan",
    "report_run",
    "write_sensor",
]

_HOME = {
    "Aids": "filters.ins_aids",
    "Filter": "filters.attitude",
    "Ins": "filters.ins",
    "InsErrorFilter": "filters.ins_error",
    "InsErrorOptions": "filters.ins_error",
    "InsErrorRun": "filters.ins_error",
    "InsRun": "filters.ins_answers",
    "LinearModel": "filters.linear_model",
    "MagnetometerCalibration": "filters.calibration",
    "Observer": "filters.observer",
    "ObserverOptions": "filters.observer",
    "ObserverRun": "filters.observer",
    "Options": "filters.options",
    "Plan": "filters.observer_plan",
    "Plant": "filters.plant",
    "Recording": "io.recordings",
    "Run": "filters.attitude_answers",
    "calibrate_magnetometer": "filters.calibration",
    "declination_rad": "filters.declination",
    "plot_run": "reports.runs",
    "read": "io.readers",
    "read_grade": "io.sensors",
    "read_plan": "filters.observer_plan",
    "report_run": "reports.runs",
    "write_sensor": "io.sensors",
}


def __getattr__(name: str) -> object:
    """What is not loaded yet (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'hnav' has no attribute '{name}'")
    value: object = getattr(import_module(f"hnav.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
