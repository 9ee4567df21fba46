"""Findings of a run: an opened lid, samples beyond their gate."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import hnav
from command_line import answered
from command_line import hnav as command
from hnav.cli.observe import unmodelled_events
from hnav.filters.observer import Observer
from hnav.filters.observer_findings import findings, moment
from hnav.filters.observer_plan import read_plan
from hnav.io.sample_table import read_sample_table
from observer.test_fmu_plants import T_S, little_plan, samples
from studies import thermal_box
from studies.command import main_of

HOURS = 0.8


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A folder with the model, its plan and a recording in which the lid is open for three minutes."""
    folder = tmp_path_factory.mktemp("box")
    thermal_box.write_example(folder, HOURS)
    return folder


def test_an_opened_lid_is_found(box):
    columns = thermal_box.recorded(np.random.default_rng(3), HOURS)
    result = thermal_box.observed(read_plan(box / "plan.toml"), columns, HOURS, tuned=False)
    assert (result["missed"], result["false"]) == (0, 0)
    assert 0 <= result["late_s"][0] < 20 and 0 <= result["long_s"][0] < 40


def test_the_same_as_an_fmu_with_tuned_noises(plants, tmp_path):
    """Noise of the heater would explain these samples better than the lid; the tuned plan still has to find the lid."""
    columns = thermal_box.recorded(np.random.default_rng(0), 2.0)
    result = thermal_box.observed(thermal_box.plan_of_model(tmp_path)[1], columns, 2.0)
    assert (len(result["late_s"]), result["missed"], result["false"]) == (3, 0, 0)
    assert all(0.8 < nis < 1.2 for nis in result["nis"])


def test_the_command_names_the_interval(box):
    page = box / "page.html"
    pytest.importorskip("plotly", reason="Plotly is not installed: no pages")
    printed = command("observe", box / "box.py", "--plan", box / "plan.toml", "--data", box / "recording.csv", "--report", page)
    assert printed.returncode == 0, printed.stderr
    assert "G_box was beyond 3 sigma of its usual 0.9" in printed.stdout
    assert "from 2406 s (2020-09-13 13:06:49 UTC) to 2604 s (2020-09-13 13:10:07 UTC)" in printed.stdout
    assert "T2 reads 0.28 more than expected in the median: offset = -0.28 in its table takes it away" in printed.stdout
    assert "not in the plan, and not used: fan_on" in printed.stdout
    assert 'id="findings"' in page.read_text() and 'id="events"' not in page.read_text()


def test_a_file_of_python_is_a_plant(box, tmp_path):
    printed = command("observe", box / "box.py")
    assert printed.returncode == 0 and "box.py: functions in Python, 2 states" in printed.stdout
    plan = tmp_path / "plan.toml"
    plan.write_text(printed.stdout[printed.stdout.index("[plant]") :])
    fits = command("observe", box / "box.py", "--plan", plan)
    assert fits.stdout == "box.py and plan.toml fit: heater, air by air\n", fits.stderr
    (tmp_path / "none.py").write_text("x = 1\n")
    assert "none.py has no hnav.Plant at its top" in command("observe", tmp_path / "none.py").stderr
    assert "there is no such file" in command("observe", tmp_path / "missing.py").stderr


def test_several_sensors_read_one_variable_each_with_its_offset(little_fmu):
    """One sensor has the plant's unit; the other reads millimetres with an offset of a metre."""
    y = samples()
    plan = little_plan(little_fmu)
    plan.sensor("second", of="x", noise=20, unit="mm", offset=-1000)
    run = Observer(plan).run(T_S, {"x": y, "second": 1000 * y + 1000})
    assert run.innovation["second"] == pytest.approx(1000 * run.innovation["x"], abs=1e-6)
    # Two samples of one noise are one of half its variance.
    once = Observer(little_plan(little_fmu).sensor("x", noise=0.02 / np.sqrt(2))).run(T_S, {"x": y})
    assert run.x["v"] == pytest.approx(once.x["v"], abs=1e-9)
    with pytest.raises(hnav.HnavValueError, match="no variable 'zz'"):
        plan.sensor("third", of="zz", noise=1)


def test_an_input_has_its_column_and_factor(little_fmu):
    plan, scaled = little_plan(little_fmu), little_plan(little_fmu).input("u", column="switch", factor=2.5)
    switch = np.sin(T_S)
    run, expected = (
        Observer(p).run(T_S, {"x": samples()}, {"u": u}) for p, u in ((scaled, switch), (plan.input("u"), 2.5 * switch))
    )
    assert np.array_equal(run.x["v"], expected.x["v"]) and scaled.inputs["u"].column == "switch"
    with pytest.raises(hnav.HnavValueError, match="factor of u is 0"):
        plan.input("u", factor=0)


def test_an_input_may_be_a_line_between_its_samples(little_fmu):
    """Linear interpolation of a ramp sampled at every tenth row returns the ramp."""
    plan, line = little_plan(little_fmu).input("u"), little_plan(little_fmu).input("u", interpolation="linear")
    ramp = 3.0 * T_S
    middles = np.append(ramp[:-1] + 1.5 * np.diff(T_S), ramp[-1])
    seldom = np.where(np.arange(len(T_S)) % 10 == 0, ramp, np.nan)
    seldom[-1] = ramp[-1]
    expected = Observer(plan).run(T_S, {"x": samples()}, {"u": middles})
    run = Observer(line).run(T_S, {"x": samples()}, {"u": seldom})
    assert run.x["v"] == pytest.approx(expected.x["v"], abs=1e-9)
    once = np.where(np.arange(len(T_S)) == 3, 2.0, np.nan)
    held, alone = (Observer(p).run(T_S, {"x": samples()}, {"u": once}) for p in (plan, line))
    assert np.array_equal(held.x["v"], alone.x["v"])
    with pytest.raises(hnav.HnavValueError, match="interpolation of u is 'cubic': it must be hold or linear"):
        plan.input("u", interpolation="cubic")


def test_samples_beyond_the_gate_are_one_interval(little_fmu):
    y = samples()
    y[60:64] += 2.0
    plan = little_plan(little_fmu).sensor("x", noise=0.02, gate_nis=10.8)
    (found,) = [one for one in findings(Observer(plan).run(T_S, {"x": y}), plan) if one.kind == "beyond its gate"]
    assert found.start_s == T_S[60] and found.end_s == T_S[63]
    assert found.sentence().startswith("x: ") and " samples beyond the gate from 3 s to " in found.sentence()


def test_a_run_with_the_stated_noises_has_no_findings(little_fmu):
    plan = little_plan(little_fmu)
    assert findings(Observer(plan).run(T_S, {"x": samples()}), plan) == []
    assert findings(Observer(plan).run(T_S[:0], {"x": samples()[:0]}), plan) == []


def test_times_of_findings_are_relative_to_the_origin():
    assert moment(12.5, 10) == "2.5 s" and moment(1.6e9 + 1, 1.6e9) == "1 s (2020-09-13 12:26:41 UTC)"


def test_the_study_has_a_row(monkeypatch):
    monkeypatch.delenv("HNAV_PLANTS", raising=False)
    monkeypatch.setattr(thermal_box, "tune", lambda plan, *_: type("Tuned", (), {"plan": plan}))
    printed = answered(main_of("thermal_box"), "--runs", "1", "--hours", "0.75")
    assert printed.returncode == 0 and "functions in Python" in printed.stdout, printed.stderr


def test_times_of_recordings(tmp_path):
    def times(name, *cells):
        (tmp_path / "r.csv").write_text("\n".join([f"{name},on,note", *(f"{c},{s},x" for c, s in zip(cells, ("True", "off")))]))
        return read_sample_table(tmp_path / "r.csv", {"on"})

    expected = [1600000000.0, 1600000003.5]
    for name, cells in (
        ("time", ("1600000000", "1600000003.5")), ("time", ("1600000000000000000", "1600000003500000000")),
        ("timestamp", ("1600000000000", "1600000003500")), ("t", ("2020-09-13 12:26:40", "2020-09-13T12:26:43.5")),
        ("t", ("2020-09-13 14:26:40+02:00", "2020-09-13T12:26:43.5Z")), ("t", ("13.09.2020 12:26:40", "13.09.2020 12:26:43.5")),
        ("t", ("09/13/2020 12:26:40 PM", "09/13/2020 12:26:43.5 PM")),
    ):  # fmt: skip
        t_s, columns = times(name, *cells)
        assert t_s == pytest.approx(expected, abs=1e-6)
        assert columns["on"].tolist() == [1, 0] and np.isnan(columns["note"]).all()
    assert times("t", "23:59:59.5", "00:00:01")[0].tolist() == [86399.5, 86401]
    assert times("t", "1.5 min", "2 min")[0].tolist() == [90, 120]
    with pytest.raises(hnav.HnavValueError, match="t is no time in row 2: soon"):
        times("t", "2020-09-13 12:26:40", "soon")
    with pytest.raises(hnav.HnavValueError, match="note is no number in row 1: x"):
        read_sample_table(tmp_path / "r.csv")
    assert pd.read_csv(tmp_path / "r.csv").shape == (2, 3)


@pytest.mark.parametrize(
    "text",
    [
        "t_s,a,b\n0,1.5,\n0.25,NA,2\n", "Time;a;b\n0;1,5;\n0,25;-;2\n", "t_s\ta\tb\n0\t1.5\n0.25\t\t2\n",
        "# a note\n# t_s a b\n0 1.5 nan\n0.25 nan 2\n", "time_ms,a,b\n0,1.5,null\n250,unknown,2\n",
        "\ufefftime [s], a, b,\n0,1.5,,\n0.25,n/a,2,\n", "T,a,b,time\n7,1.5,,0\n8,,2,0.25\n", "b\ta\ttime\n\t1.5\t0\n2\t\t0.25\n",
        "# t;a;b\n0;1,5;nan\n0,25;nan;2\n",
    ],
)  # fmt: skip
def test_tables_as_programs_write_them(tmp_path, text):
    (tmp_path / "r.csv").write_text(text, encoding="utf-8")
    t_s, columns = read_sample_table(tmp_path / "r.csv", {"a", "b"})
    assert t_s.tolist() == [0, 0.25]
    assert columns["a"].tolist()[0] == 1.5 and columns["b"].tolist()[1] == 2
    assert np.isnan([columns["a"][1], columns["b"][0]]).all()


def test_a_day_and_a_clock_and_a_degree_sign(tmp_path):
    (tmp_path / "r.csv").write_bytes("Date;Time;T [°C]\n2020-09-13;12:26:40;21,5\n".encode("cp1252"))
    t_s, columns = read_sample_table(tmp_path / "r.csv", {"T [°C]"})
    assert t_s.tolist() == [1600000000.0] and columns["T [°C]"].tolist() == [21.5]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t_s,a,a\n0,1,2\n", "two columns a"),
        ("t_s,a\n0,1,2\n", "row 1 has 3 cells, the header 2"),
        ("# t_s,a\n", "no table"),
        (f't_s,a\n0,"{"1" * 200_000}\n', "quotation mark"),
    ],
)
def test_tables_that_are_none(tmp_path, text, said):
    (tmp_path / "r.csv").write_text(text)
    with pytest.raises(hnav.HnavValueError, match=said):
        read_sample_table(tmp_path / "r.csv")


def test_events_that_the_covariance_does_not_pass_are_reported():
    assert unmodelled_events(SimpleNamespace(info=lambda: SimpleNamespace(chattering=0))) == []
    printed = unmodelled_events(SimpleNamespace(info=lambda: SimpleNamespace(chattering=7)))
    assert len(printed) == 1 and printed[0].startswith("7 events came beyond the fiftieth of an interval")
