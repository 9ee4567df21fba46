"""Each archive holds an input and the FMU's outputs for it (fmi-ls-ref); any importer can run them, as is done here."""

import csv
import io
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest

from hnav.fmi.fmus import Fmu, fmu_path

FMUS = (
    "Hrekf", "Ahrs", "Turntable", "ImuMagSensor", "InsErrorFilterLateral", "InsErrorFilterLongitudinal", "AircraftInsLateral",
    "AircraftInsLongitudinal", "Pendulum", "Ins", "Vehicle", "Gnss", "Baro", "Wheel",
)  # fmt: skip
FOLDER = "extra/org.fmi-standard.fmi-ls-ref"


def table(text: str) -> tuple[list[str], np.ndarray]:
    rows = list(csv.reader(io.StringIO(text)))
    return rows[0], np.array(rows[1:], float)


@pytest.mark.parametrize("name", FMUS)
@pytest.mark.parametrize("version", (2, 3))
def test_the_fmu_answers_its_reference_input_as_its_archive_says(name, version):
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        read = lambda file: archive.read(f"{FOLDER}/{file}").decode()  # noqa: E731
        manifest, experiment = (
            ET.fromstring(read("fmi-ls-manifest.xml")),
            ET.fromstring(read("experiments.xml")).find("Experiment"),
        )
        stimuli, reference = experiment.find("Stimuli"), experiment.find("References").get("source")
        names, rows = table(read(stimuli.get("source"))) if stimuli is not None else (["time"], np.zeros((1, 1)))
        outputs, expected = table(read(reference))
    assert manifest.find("File").get("source") == "experiments.xml"
    step_s, stop_s, tolerance = (float(experiment.get(what)) for what in ("stepSize", "stopTime", "tolerance"))
    with Fmu(fmu_path(name, version)) as fmu:
        assert (stimuli is None) == (not any(v.causality == "input" for v in fmu.variables.values()))
        fmu.initialise()
        times = [0.0]
        for k in range(round(stop_s / step_s)):
            row = rows[np.searchsorted(rows[:, 0], k * step_s + 1e-9, side="right") - 1]
            for variable, value in zip(names[1:], row[1:]):
                fmu.set(variable, bool(value) if fmu.variables[variable].type == "Boolean" else value)
            fmu.do_step(k * step_s, step_s)
            times.append((k + 1) * step_s)
            for shown in expected[np.abs(expected[:, 0] - times[-1]) < 1e-9]:
                for variable, value in zip(outputs[1:], shown[1:]):
                    exact = fmu.variables[variable].type not in ("Real", "Float64")
                    assert abs(fmu.get(variable) - value) <= (0 if exact else tolerance * max(1, abs(value))), variable
    assert len(expected) == 20 and expected[-1, 0] == pytest.approx(stop_s)
    used = [
        i for i, variable in enumerate(outputs) if variable in ("count.accel_used", "count.samples", "z.sample", "gyro.sample")
    ]
    assert not used or expected[-1, used[0]] > 20  # the run is one of samples
