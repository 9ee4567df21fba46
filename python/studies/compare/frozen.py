"""The answers of the old library to the short cases of python_tests/frozen_cases.py, for the tests to keep.

python -m studies.compare.frozen CHECKOUT [CASE]...

After a change of the mathematics its cases are answered anew by this checkout: CHECKOUT is `.`, and the cases are named;
the others stay as they are.
"""

from __future__ import annotations

import importlib
import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hnav.io.outputs import write_files
from studies.compare import attitude, calibration, ins_error
from studies.compare.fmi import TRUTH, open_fmu
from studies.compare.fmu import Values
from studies.compare.inputs import Samples
from studies.compare.old_revision import TOP
from studies.compare.side import Side

TESTS = TOP / "python_tests"
FILE = TESTS / "frozen_answers.npz"
sys.path.insert(0, str(TESTS))
cases = importlib.import_module("frozen_cases")


def answers(side: Side) -> dict[str, NDArray[Any]]:
    """By "case/value"."""
    found: dict[str, dict[str, NDArray[Any]]] = {}
    m = cases.motion()
    samples = Samples(m.t_s, m.rate, m.force, m.field, np.zeros_like(m.t_s))
    for name, (filter, preset, settings) in cases.ATTITUDE.items():
        run = attitude.batch(attitude.open_filter(side, filter, preset, **settings), samples, chunk=len(m.t_s))
        found[name] = _rows(run, cases.OUTPUTS, cases.ROWS) | {"used": run["diagnostics.used"][-1]}
    for name, settings in cases.SMOOTHED.items():
        run = attitude.batch(attitude.open_filter(side, "ahrs", **settings), samples, "smooth", chunk=len(m.t_s))
        found[name] = _rows(run, cases.OUTPUTS[:4], cases.ROWS)
    model, (u, z) = cases.ins_model(), cases.ins_signals()
    sizes = {"nx": 3, "nu": 1, "nz": 2, "nw": 3, "nl": 2}
    for name, settings in cases.INS_ERROR.items():
        run = ins_error.batch(side, sizes | model, z, u, **settings)
        found[name] = _rows(run, cases.INS_OUTPUTS, cases.STEPS)
    for name, settings in cases.CALIBRATION.items():
        fit = calibration.calibrate(side, *map(np.ascontiguousarray, cases.turned_magnetometer()), **settings)
        found[name] = {value: fit[value] for value in cases.CALIBRATED}
    found["sensor"] = {"values": sensor(side)}
    return {f"{case}/{value}": array for case, values in found.items() for value, array in values.items()}


def _rows(run: dict[str, NDArray[Any]], names: tuple[str, ...], rows: slice) -> dict[str, NDArray[Any]]:
    return {name: np.squeeze(run[name][rows]) for name in names}


def sensor(side: Side) -> NDArray[Any]:
    """The sensor on the turntable, FMI 2.0: what it shows after each step."""
    with open_fmu(side, "Turntable", 2, **cases.TABLE) as table, open_fmu(side, "ImuMagSensor", 2, **cases.SENSOR) as target:
        for fmu in (table, target):
            fmu.initialise(0.0)
        source, sink, shown = Values(table, TRUTH), Values(target, TRUTH), Values(target, cases.SENSOR_OUTPUTS)
        rows, step_s = [], cases.SENSOR_STEP_S
        for k in range(round(cases.SENSOR_STOP_S / step_s)):
            sink.set(source.get())
            for fmu in (table, target):
                fmu.fmu.doStep(k * step_s, (k + 1) * step_s - k * step_s)
            rows.append(shown.get())
        return np.array(rows[cases.STEPS])


def main(checkout: str, *only: str) -> None:
    found: dict[str, Any] = answers(Side(Path(checkout), Path()))
    if only:
        with np.load(FILE) as kept:
            found = dict(kept) | {name: values for name, values in found.items() if name.partition("/")[0] in only}
    packed = io.BytesIO()
    np.savez_compressed(packed, **found)
    write_files({FILE: packed.getvalue()})
    print(f"{FILE}: {len(found)} arrays, {sum(a.size for a in found.values())} numbers, {FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main(*sys.argv[1:])
