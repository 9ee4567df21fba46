"""hnav observe: what an FMU offers, a first plan, and estimates from a table."""

import tomllib

import numpy as np
import pandas as pd
import pytest

from command_line import hnav
from hnav.filters.observer import Observer
from hnav.reports.observer_page import _shown_to
from observer.little_fmu import MODES, packed
from observer.test_fmu_plants import T_S, little_plan, samples
from observer.test_plan_files import TEXT


@pytest.fixture
def files(little_fmu, tmp_path):
    """A plan, and samples of x at every second instant."""
    plan, data = tmp_path / "plan.toml", tmp_path / "data.csv"
    plan.write_text(TEXT)
    x = np.where(np.arange(len(T_S)) % 2 == 0, samples(), np.nan)
    pd.DataFrame({"t_s": T_S, "x": x, "u": np.sin(T_S), "other": 1}).to_csv(data, index=False)
    return plan, data, tmp_path / "out.csv"


def test_without_a_plan_the_variables_and_a_valid_first_plan_are_printed(little_fmu, tmp_path):
    printed = hnav("observe", little_fmu)
    assert printed.returncode == 0
    for line in (
        "little.fmu: Little, FMI 2, 2 states", "states: x [m], v", "sensors may be: x [m], y [m], v", "inputs: u, d",
        "parameters that may be estimated: k", "exported as tunable: mode",
    ):  # fmt: skip
        assert line in printed.stdout
    plan = tmp_path / "plan.toml"
    plan.write_text(printed.stdout)
    fits = hnav("observe", little_fmu, "--plan", plan)
    assert (fits.returncode, fits.stdout) == (0, "little.fmu and plan.toml fit: x, v by x\n")


def test_the_results_of_the_derivative_check_are_printed(little_fmu, files):
    printed = hnav("observe", little_fmu, "--prove")
    assert "# derivatives by states: right (worst: " in printed.stdout
    assert tomllib.loads(printed.stdout)["plant"] == {"fmu": "little.fmu"}
    plan = files[0]
    plan.write_text(TEXT.replace("mode = 0", "mode = 5"))
    printed = hnav("observe", little_fmu, "--plan", plan, "--prove")
    assert "the plant says d der(v) / d v = 0.3, differences -0.3" in printed.stdout
    assert "derivatives by states: wrong, differences are used" in printed.stdout


def test_a_table_of_samples_becomes_a_table_of_estimates(little_fmu, files):
    plan, data, out = files
    done = hnav("observe", little_fmu, "--plan", plan, "--data", data, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "not in the plan, and not used: other" in done.stdout
    assert "x: 40 samples, mean NIS" in done.stdout
    assert out.read_text().startswith("# hnav ")
    table = pd.read_csv(out, comment="#", dtype=str).astype(float)
    given = pd.read_csv(data, dtype=str).astype(float)
    expected = Observer(little_plan(little_fmu), horizon_s=0.1).run(T_S, {"x": given["x"]}, {"u": given["u"]})
    assert list(table) == ["t_s", "x", "v", "sigma.x", "sigma.v", "innovation.x", "nis.x", "ready"]
    assert np.array_equal(table["v"], expected.x["v"])
    assert np.array_equal(table["nis.x"], expected.nis["x"], equal_nan=True)


def test_a_table_and_a_page_with_hindsight(little_fmu, files, tmp_path):
    pytest.importorskip("plotly", reason="Plotly is not installed: no pages")
    plan, data, out = files
    page = tmp_path / "page.html"
    done = hnav("observe", little_fmu, "--plan", plan, "--data", data, "--out", out, "--report", page, "--smooth")
    assert done.returncode == 0, done.stderr
    assert "# smoothed: every row from all samples" in out.read_text()
    assert "every row from all samples" in page.read_text()
    table = pd.read_csv(out, comment="#", dtype=str).astype(float)
    given = pd.read_csv(data, dtype=str).astype(float)
    expected = Observer(little_plan(little_fmu), horizon_s=0.1).smooth(T_S, {"x": given["x"]}, {"u": given["u"]})
    assert np.array_equal(table["v"], expected.x["v"]) and np.array_equal(table["sigma.x"], expected.sigma["x"])


def test_a_page_shows_estimates_innovations_and_derivatives(little_fmu, files, tmp_path):
    pytest.importorskip("plotly", reason="Plotly is not installed: no pages")
    plan, data, _ = files
    plan.write_text(TEXT.replace("mode = 0", "mode = 5"))
    page = tmp_path / "pages" / "page.html"
    done = hnav("observe", little_fmu, "--plan", plan, "--data", data, "--report", page)
    assert done.returncode == 0, done.stderr
    assert f"80 rows to {page}" in done.stdout
    text = page.read_text()
    for part in (
        'id="estimates"',
        'id="innovations"',
        'id="nis"',
        'id="sensors"',
        'id="proof"',
        "<td>m</td>",
        "wrong: differences are used",
    ):
        assert part in text
    assert "the plant says d der(v) / d v = 0.3" in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--data", "DATA"], "--data belongs to --out, --report, --check or --tune"),
        (["--data", "DATA", "--out", "OUT"], "a plan is missing"),
        (["--plan", "PLAN", "--smooth"], "--smooth belongs to --out or --report"),
        (["--plan", "PLAN", "--data", "DATA", "--out", "DATA"], "is read by this command"),
        (["--plan", "PLAN", "--data", "PLAN", "--out", "OUT"], "plan.toml"),
        (["--plan", "nowhere.toml"], "nowhere.toml"),
        (["--plan", "PLAN", "--export", "OUT", "--fmi", "1"], "--fmi is 1: it must be 2 or 3"),
        (["--plan", "PLAN", "--export", "OUT", "--period", "0"], "--period is 0: it must lie in"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_line(little_fmu, files, arguments, said):
    places = dict(zip(("PLAN", "DATA", "OUT"), files))
    done = hnav("observe", little_fmu, *(places.get(a, a) for a in arguments))
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert said in done.stderr


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("a,x\n0,1\n", "has no column of times: call it t_s; it has a, x"),
        ("t_s,x\n0,1\n1,two\n", "x is no number in row 2: two"),
        ("t_s,x\n1,1\n0,1\n", "t_s does in row 2"),
        ("t_s,y\n0,1\n", "no column of a sensor: the plan names x, it has y"),
        ("", "no table"),
    ],
)
def test_a_table_that_is_wrong_is_refused_by_its_row(little_fmu, files, table, said):
    plan, data, out = files
    data.write_text(table)
    done = hnav("observe", little_fmu, "--plan", plan, "--data", data, "--out", out)
    assert done.returncode == 2 and said in done.stderr
    assert not out.exists()


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("nan_after_1", "gave a number that is not finite for its derivatives at t = 1"), ("error_after_1", "the spring broke"),
        ("fatal_after_1", "the house burnt down"),
    ],
)  # fmt: skip
def test_the_reason_of_dropped_instants_is_printed(little_fmu, files, mode, said):
    plan, data, out = files
    plan.write_text(TEXT.replace("mode = 0", f"mode = {MODES.index(mode)}"))
    done = hnav("observe", little_fmu, "--plan", plan, "--data", data, "--out", out)
    lines = [line for line in done.stdout.splitlines() if "look at the model there" in line]
    assert done.returncode == 1 and lines and all(said in line for line in lines)
    assert any("instants were dropped" in line for line in lines) == (mode != "nan_after_1")


def test_innovations_larger_than_stated_are_reported(little_fmu, files):
    plan, data, out = files
    for noise, said in (("0.002", "larger than stated"), ("0.2", "smaller than stated")):
        plan.write_text(TEXT.replace("0.02", noise))
        assert said in hnav("observe", little_fmu, "--plan", plan, "--data", data, "--out", out).stdout


def test_an_fmu_that_cannot_be_observed(little_binary, tmp_path):
    fmu = packed(tmp_path / "ball.fmu", little_binary, indicators=1)
    done = hnav("observe", fmu)
    assert done.returncode == 2 and "1 state event and cannot save its state" in done.stderr


def test_innovations_are_drawn_at_their_own_size():
    sigma, innovation = np.full(100, 0.1), np.full(100, 0.05)
    sigma[0] = innovation[0] = 50.0
    innovation[50] = 2.0
    assert 0.3 < _shown_to(sigma, np.array([0.05] * 100)) < 1
    assert _shown_to(sigma, innovation) > 2
    assert _shown_to(np.zeros(3), np.zeros(3)) == 1


PENDULUM = """import hnav
import numpy as np
def derivatives(t, x, u, p):
    {line}
    return x[1], -9.81 * np.sin(x[0])
plant = hnav.Plant(derivatives, lambda t, x, u, p: {sensor}, states={{"angle": 0.1, "rate": 0.0}}, sensors=["angle"])
"""
PLAN = "[sensor.angle]\nnoise = 0.01\n[state.angle]\nstart_sigma = 0.1\n[state.rate]\nstart_sigma = 0.1\nnoise = 0.01\n"


def observed(folder, line="", sensor="x[0]"):
    """hnav observe over a pendulum in Python whose samples are free of noise."""
    plant, plan, data = folder / "pendulum.py", folder / "plan.toml", folder / "samples.csv"
    plant.write_text(PENDULUM.format(line=line, sensor=sensor))
    plan.write_text(PLAN)
    t = np.arange(0, 3, 0.01)
    np.savetxt(data, np.stack([t, 0.1 * np.cos(3.13 * t)], 1), delimiter=",", header="t_s,angle", comments="")
    return hnav("observe", plant, "--plan", plan, "--data", data, "--out", folder / "out.csv")


def test_what_a_plant_in_python_raises_is_one_line_with_its_place(tmp_path):
    for line, said in (("if t > 1: 1 / 0", "line 4: ZeroDivisionError: division by zero"), ("def (", "line 4: SyntaxError")):
        done = observed(tmp_path, line)
        assert done.returncode == 2 and f"pendulum.py, {said}" in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_sensor_that_no_state_moves_and_samples_without_noise_are_said(tmp_path):
    assert "angle depends on nothing that is estimated" in observed(tmp_path, sensor="3.0").stdout
    done = observed(tmp_path)
    assert "depends on nothing" not in done.stdout and "as beside a plant without noise, it is not ready" in done.stdout
