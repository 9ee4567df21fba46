"""An exported observer in other importers: PyFMI gives the same bits as hnav's, OMSimulator the same values to 1e-9."""

import json

import pytest

import hnav
from hnav.fmi.fmus import Fmu
from importers import run_omsimulator, run_pyfmi_script
from observer.test_fmu_plants import little_plan

STEP_S, STEPS = 0.0625, 40
OUTPUTS = [f"{of}.{name}" for of in ("est", "post", "sigma") for name in "xvdk"] + ["cov[1,2]"]
PYFMI = """
import json, sys, warnings
warnings.simplefilter("ignore")
from pyfmi import load_fmu
given = json.load(open("given.json"))
model = load_fmu(sys.argv[1], kind="CS")
model.setup_experiment(start_time=0.0)
model.initialize()
for k, value in enumerate(given["samples"]):
    model.set("x.value", value)
    assert model.do_step(k * given["step_s"], given["step_s"], True) == 0
ends = {name: float(model.get(name)[0]) for name in given["outputs"]}
json.dump({"ends": ends, "log": model.get_log()}, open("answer.json", "w"))
"""


def exported(fmu, path, version):
    plan = little_plan(fmu).parameter("k", start_sigma=0.5).unknown_input("d", start_sigma=0.1, noise=0.01)
    hnav.Observer(plan).export(path, version, period_s=STEP_S)
    return path


def ends_of_hnav(path, samples):
    with Fmu(path) as fmu:
        fmu.initialise()
        for k, value in enumerate(samples):
            if value is not None:
                fmu.set("x.value", value)
            fmu.do_step(k * STEP_S, STEP_S)
        return {name: fmu.get(name) for name in OUTPUTS}


def test_pyfmi_ends_in_the_same_bits(little_fmu, tmp_path):
    path = exported(little_fmu, tmp_path / "o.fmu", 2)
    samples = [1 - 0.03 * k + 0.01 * (k * k % 7) for k in range(STEPS)]
    (tmp_path / "given.json").write_text(json.dumps({"samples": samples, "step_s": STEP_S, "outputs": OUTPUTS}))
    answer = run_pyfmi_script(PYFMI, (str(path),), tmp_path)
    assert answer["errors"] == [] and answer["ends"] == ends_of_hnav(path, samples)


@pytest.mark.parametrize("version", [2, 3])
def test_omsimulator_ends_within_1e_9(little_fmu, tmp_path, version):
    path = exported(little_fmu, tmp_path / "o.fmu", version)
    options = f"--stopTime={STEPS * STEP_S + 1}", f"--stepSize={STEP_S}", "--mode=cs"
    row = run_omsimulator(path, tmp_path, STEPS * STEP_S, *options)
    expected = ends_of_hnav(path, [None] * STEPS)
    assert {name: row[name] for name in OUTPUTS} == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert row["count.x.used"] == STEPS and row["est.x"] != 1
