"""Systems and results that others wrote, under damage of every kind: read whole, or refused in one line that names the file."""

import copy
import functools
import json
import os
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from command_line import hnav
from fuzzing import DEEP, bounded, damaged, json_values, with_another_value
from hnav.certify.results_folder import filter_of_run, read_results
from hnav.errors import HnavError
from hnav.filters.options import Options
from hnav.fmi.fmus import fmu_path
from hnav.io.json_file import read_json
from hnav.systems.master import communication_points
from hnav.systems.simulation import Run, read_run, write_run
from hnav.systems.ssp_reader import read_system
from importing import built_fmu
from made_systems import make_system, parameter_set

bounded_pages = settings(bounded, max_examples=max(1, bounded.max_examples // 20))


def or_one_line(read, *arguments, names: str = ""):
    """The result of the reader; None when it refuses with an HnavError."""
    try:
        return read(*arguments)
    except HnavError as error:
        assert "\n" not in str(error) and len(str(error)) < 2000 and names in str(error), str(error)
        return None


# --------------------------------------------------------------------------------------------- systems

ODD = ["", " ", "0", "-1", "1e308", "1e999", "nan", "inf", "-inf", "1e-300", "9" * 400, "99999999999", "x" * 300, "..", "/", "a/../..",
       "http://[", "file:///etc/passwd", "C:\\x", "resources/Hrekf.fmu", "first", "none", "true", "kl", "input", "Real", "%s{}", "ä\u2028"]  # fmt: skip


@pytest.fixture(scope="module")
def system(tmp_path_factory) -> Path:
    built_fmu("Hrekf")
    folder = make_system(tmp_path_factory.mktemp("system"), {"first": "Hrekf", "second": "Hrekf"},
                         [("first.att.heading", "second.aid.heading")], {"first.robust.gamma": 2.0, "first.robust.gamma_mode": "kl"})  # fmt: skip
    text = (folder / "SystemStructure.ssd").read_text()
    more = ('<ssd:Units><ssd:Unit/></ssd:Units><ssd:DefaultExperiment startTime="0" stopTime="1"/></ssd:SystemStructureDescription>'
            .replace("<ssd:Unit/>", '<ssc:Unit name="rad"><ssc:BaseUnit rad="1" factor="1"/></ssc:Unit>'))  # fmt: skip
    (folder / "SystemStructure.ssd").write_text(text.replace("</ssd:SystemStructureDescription>", more))
    (folder / "scenario_calm.ssv").write_text(parameter_set({"first.robust.gamma": 3.0, "second.robust.gamma_mode": "off"}))
    return folder


def read_and_choose(path: Path) -> None:
    with read_system(path) as found:
        for scenario in found.scenarios:
            found.choose(scenario=scenario)
        found.seed(1) if any("seed" in c.variables for c in found.components.values()) else None
        assert found.components and all(c.fmu.is_file() for c in found.components.values())
        assert all(value is None or np.isfinite(value) for value in (found.start_s, found.stop_s, found.step_s))


@bounded
@given(data=st.data(), name=st.sampled_from(["SystemStructure.ssd", "scenario_calm.ssv"]))
def test_a_system_with_anything_in_any_place_is_read_or_refused(system, data, name):
    tree = ElementTree.parse(system / name)
    good = (system / name).read_bytes()
    elements = list(tree.iter())
    for _ in range(data.draw(st.integers(1, 2))):
        element = data.draw(st.sampled_from(elements))
        match data.draw(st.sampled_from(["value", "value", "drop", "double", "move"])):
            case "value" if element.attrib:
                element.set(data.draw(st.sampled_from(sorted(element.attrib))), data.draw(st.sampled_from(ODD)))
            case "drop" if element.attrib:
                element.attrib.pop(data.draw(st.sampled_from(sorted(element.attrib))))
            case "double":
                element.extend(copy.deepcopy(list(element)))
            case _:
                element[:] = []
    try:
        tree.write(system / name)
        or_one_line(read_and_choose, system)
    finally:
        (system / name).write_bytes(good)


@bounded
@given(seed=st.integers(0, 2**32), name=st.sampled_from(["SystemStructure.ssd", "scenario_calm.ssv", "x.ssp"]))
def test_a_damaged_system_is_read_or_refused(system, tmp_path_factory, seed, name):
    archive = tmp_path_factory.mktemp("damaged") / "x.ssp"
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as target:
        for path in sorted(system.iterdir()):
            data = path.read_bytes()
            target.writestr(path.name, damaged(data, seed) if path.name == name else data)
        if name != archive.name:
            target.write(fmu_path("Hrekf", 2), "resources/Hrekf.fmu")
    if name == archive.name:
        archive.write_bytes(damaged(archive.read_bytes(), seed))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(tempfile, "tempdir", str(archive.parent))
        or_one_line(read_and_choose, archive)
    assert list(archive.parent.iterdir()) == [archive]


@bounded
@given(*[st.one_of(st.floats(), st.sampled_from([0.0, 1e308, 1e-300, 1e9, 1e-9]))] * 3)
@example(0.0, 1e308, 0.01)
@example(0.0, 10.0, 1e-300)
@example(1e17, 1e17 + 64, 1e-3)
def test_any_times_give_points_that_increase_or_one_line(start_s, stop_s, step_s):
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(os, "sysconf", lambda name: 4096)  # a machine of 16 MB
        points = or_one_line(communication_points, start_s, stop_s, step_s, 10)
    assert points is None or (0 < len(points) < 2**18 and np.isfinite(points).all() and (np.diff(points) > 0).all())


def test_times_that_no_machine_can_keep_are_one_line_of_the_command(system, tmp_path):
    ssd = (system / "SystemStructure.ssd").read_text()
    make = tmp_path / "long"
    make.mkdir()
    (make / "SystemStructure.ssd").write_text(ssd.replace('stopTime="1"', 'stopTime="1e308"'))
    recording = tmp_path / "x.csv"
    recording.write_text("t_s,gx,gy,gz,ax,ay,az\n0,0.01,0,0,0,0,-9.81\n0.01,0,0.01,0,0,0,-9.81\n")
    filtered = ("filter", recording, "--engine", "fmi2-cs", "--out", tmp_path / "out.csv")
    for arguments, said in (
        (("simulate", make, "--out", tmp_path / "out"), "points need"),
        (("simulate", system, "--step", "1e-300", "--out", tmp_path / "out"), "--step 1e-300: 1e+300 points need"),
        ((*filtered, "--step", "1e-300"), "--step 1e-300: 1e+298 points need"),
        ((*filtered, "--step", "inf"), "--step inf: must be above 0 seconds"),
        (("simulate", system, "--set", "first.gate.mag_gate_nis=1e999", "--out", tmp_path / "out"), "first"),
        (("simulate", system, "--out", tmp_path / ("x" * 300) / "y"), "file name too long"),
        (("simulate", "x" * 5000 + "/", "--out", tmp_path / "out"), "file name too long"),
    ):
        done = hnav(*arguments)
        assert done.returncode == 2 and said in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
    assert not (tmp_path / "out").exists()


# --------------------------------------------------------------------------------------------- results

ABOUT = {
    "system": "made", "description": "", "scenario": None, "grade": "fine", "seed": 1, "start_s": 0.0, "stop_s": 1.0, "step_s": 0.1,
    "parameters": {"hrekf.preset": "default", "hrekf.robust.gamma": 2.0, "hrekf.start.start_q_nb[1]": 1.0, "hrekf.adaptation.adaptation": "off", "sensor.on": True},
    "components": {"hrekf": {"model": "Hrekf", "fmi": "2.0", "version": "0.2"}}, "wall_s": {"hrekf": 0.1}, "lost": {"hrekf": 0},
    "failure": "", "versions": {"hnav": "0.2.0"},
}  # fmt: skip
CERTIFICATE = {"certified": True, "reason": "", "rate_1_s": 0.1, "region_deg": None, "corrections": 3, "P": [[1.0]]}
SIZES = (("gyro.rate", 3), ("accel.force", 3), ("mag.field", 3), ("att.q", 4), ("att.sigma", 3))
COLUMNS = [f"hrekf.{name}[{i}]" for name, n in SIZES for i in range(1, n + 1)] + ["hrekf.align.started"]


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> Path:
    folder, n = tmp_path_factory.mktemp("results"), 20
    rng = np.random.default_rng(1)
    columns = {name: rng.uniform(0.1, 1.0, n) for name in COLUMNS}
    write_run(Run(0.1 * np.arange(n), columns, dict.fromkeys(columns, "1"), ABOUT), folder)
    (folder / "certificate.json").write_text(json.dumps(CERTIFICATE))
    return folder


def read_everything(folder: Path) -> Run | None:
    """By everyone who reads results; a run when it is one."""
    recording = or_one_line(read_results, folder)
    assert recording is None or (np.isfinite(recording.t_s).all() and recording.rate_b_rad_s.shape == (len(recording.t_s), 3))
    chosen = or_one_line(filter_of_run, folder)
    if chosen is not None:
        or_one_line(lambda: Options("hrekf", chosen[0], **chosen[1]))
    return or_one_line(read_run, folder, names=str(folder))


def changed(folder: Path, name: str, data: bytes) -> Run | None:
    good = (folder / name).read_bytes()
    try:
        (folder / name).write_bytes(data)
        return read_everything(folder)
    finally:
        (folder / name).write_bytes(good)


documents = st.sampled_from([("run.json", ABOUT), ("certificate.json", CERTIFICATE)])


@bounded
@given(data=st.data(), named=documents)
def test_results_with_any_value_in_any_place_are_read_or_refused(results, data, named):
    name, document = named
    other = with_another_value(copy.deepcopy(document), data) if data.draw(st.booleans()) else data.draw(json_values)
    run = changed(results, name, json.dumps(other).encode())
    assert run is None or run.t_s.shape == (20,)


@bounded
@given(seed=st.integers(0, 2**32), name=st.sampled_from(["run.json", "certificate.json", "signals.h5", "signals.h5"]))
def test_damaged_results_are_read_or_refused(results, seed, name):
    run = changed(results, name, damaged((results / name).read_bytes(), seed))
    assert run is None or all(values.shape == run.t_s.shape for values in run.columns.values())


odd_arrays = st.sampled_from([np.float64(1), np.zeros(0), np.zeros((20, 3)), np.zeros(19), np.zeros(20, complex), np.full(20, np.nan),
                              np.array([b"x"] * 20), np.zeros(20, bool), np.zeros((20, 0)), None, "group", "text"])  # fmt: skip


@bounded
@given(changes=st.dictionaries(st.sampled_from(["t_s", *COLUMNS, "new"]), odd_arrays, min_size=1, max_size=2))
def test_signals_of_any_shape_are_read_or_refused(results, tmp_path_factory, changes):
    path = tmp_path_factory.mktemp("odd") / "signals.h5"
    path.write_bytes((results / "signals.h5").read_bytes())
    with h5py.File(path, "a") as file:
        for name, value in changes.items():
            if name in file:
                del file[name]
            if isinstance(value, str) and value == "group":
                file.create_group(name)
            elif value is not None:
                file[name] = value
    run = changed(results, "signals.h5", path.read_bytes())
    assert run is None or all(values.shape == run.t_s.shape for values in run.columns.values())


@bounded_pages
@given(data=st.data(), named=documents, gone=st.sets(st.sampled_from(COLUMNS), max_size=2))
def test_what_is_read_can_be_reported_or_is_refused(results, data, named, gone):
    pytest.importorskip("plotly", reason="plotly is not installed: no report")
    from hnav.reports.page import PANELS, header, section, summary

    name, document = named
    run = changed(results, name, json.dumps(with_another_value(copy.deepcopy(document), data)).encode())
    if run is None:
        return
    for column in gone:
        del run.columns[column]
    for draw in (header, summary, *(functools.partial(section, p) for p in PANELS if p.applies(run))):
        or_one_line(draw, run)


@pytest.mark.parametrize("name", ["run.json", "certificate.json"])
@pytest.mark.parametrize("text", [DEEP, '{"parameters":' * 50_000, "[" * 500 + "]" * 500, "\xff", "", "NaN", "1" + "0" * 5000])
def test_json_that_is_none_is_one_line_of_the_command(results, name, text):
    good = (results / name).read_bytes()
    try:
        (results / name).write_text(text, encoding="latin-1")
        done = hnav("report", results)
        assert done.returncode == 2 and name in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
    finally:
        (results / name).write_bytes(good)


@bounded
@given(seed=st.integers(0, 2**32))
def test_any_json_is_read_or_refused_with_its_name(tmp_path_factory, seed):
    path = tmp_path_factory.mktemp("json") / "some.json"
    path.write_bytes(damaged(json.dumps(ABOUT).encode(), seed))
    or_one_line(read_json, path, names="some.json")
