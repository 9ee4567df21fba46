"""The report: a page that stands alone, panels that fit the run, figures that are those of the run."""

import re

import numpy as np
import pytest

from browser import LOADED, browse
from command_line import hnav
from hnav.errors import HnavError
from hnav.reports.pictures import write_pictures
from hnav.rotations import rotation_error_rad
from hnav.systems.run_views import estimates, figures, measured_field, truth_component
from hnav.systems.simulation import Run, read_run, simulate, write_run
from made_systems import NOISE, make_system, make_turntable

pytest.importorskip("plotly", reason="plotly is not installed: no report")
from plotly.offline import get_plotlyjs

from hnav.reports.attitude_panels import ATTITUDE_PANELS as DRAWN
from hnav.reports.attitude_panels import timing_panel
from hnav.reports.body_panel import body_panel
from hnav.reports.page import PANELS, write_report
from importing import built_fmu

# Panels about attitude filters; other modules add theirs for other runs. That of the body is HTML, the others are figures.
ATTITUDE_PANELS = [body_panel, *DRAWN, timing_panel]
PLOTS = [panel for panel in ATTITUDE_PANELS if panel.name != "body"]


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Run:
    for name in ("Turntable", "ImuMagSensor", "Hrekf", "Ahrs"):
        built_fmu(name)
    return simulate(
        make_turntable(tmp_path_factory.mktemp("turntable")), settings=NOISE | {"ahrs.noise.body": 1}, seed=1, stop_s=8
    )  # a hand: ready without a rest


@pytest.fixture(scope="module")
def page(run, tmp_path_factory):
    file = tmp_path_factory.mktemp("report") / "report.html"
    write_report(run, file)
    return file


def test_every_panel_is_drawn_for_a_turntable(run, page):
    assert {p.name for p in PANELS if p.applies(run)} == {p.name for p in ATTITUDE_PANELS}
    assert PANELS[-1].name == "timing"
    text = page.read_text(encoding="utf-8")
    for panel in ATTITUDE_PANELS:
        assert f'<section id="{panel.name}">' in text
        assert (f'id="plot-{panel.name}"' in text) == (panel in PLOTS)


def test_the_page_is_small(page):
    assert page.stat().st_size - len(get_plotlyjs().encode()) < 1.5e6


def test_the_page_loads_nothing_from_a_network(page):
    text = page.read_text(encoding="utf-8")
    assert not LOADED.search(text)
    assert not re.search(r"url\(\s*['\"]?https?:", re.sub(r"<script\b.*?</script>", "", text, flags=re.DOTALL))
    assert LOADED.search('<script src="https://example.org/x.js">')


def test_the_page_says_what_was_run_and_what_went_wrong(run, tmp_path):
    about = run.about | {"scenario": "a<b", "failure": "sensor failed the step from 8 s: stuck", "lost": {"hekf": 7}}
    file = tmp_path / "report.html"
    write_report(Run(run.t_s, run.columns, run.units, about), file)
    text = file.read_text(encoding="utf-8")
    for said in (
        "<h1>made</h1>",
        "a&lt;b",
        "sensor failed the step from 8 s: stuck",
        "hekf lost 7 samples",
        "parameters set",
        "hekf.robust.gamma_mode",
    ):
        assert said in text


def test_the_figures_are_those_of_the_columns(run):
    assert truth_component(run) == "turntable"
    by_name = {e.name: e for e in estimates(run)}
    assert list(by_name) == ["hekf", "hrekf", "ahrs"]
    for name, estimate in by_name.items():
        found = figures(estimate)
        started = run[f"{name}.align.started"] > 0.5
        error = rotation_error_rad(run.vector(name, "att.q", 4)[started], run.vector("turntable", "truth.q", 4)[started])
        assert found.rmse_deg == pytest.approx(np.degrees(np.sqrt(np.mean(np.sum(error**2, axis=1)))), rel=1e-12)
        assert found.final_deg == pytest.approx(np.degrees(np.linalg.norm(error[-1])), rel=1e-12)
        assert found.nis["field"][1] == 3
        assert found.nis["force"][1] == (2 if name == "ahrs" else 3)
    assert np.isfinite(by_name["ahrs"].ready_s("align.tilt_ready"))


def test_nees_of_a_known_error_is_its_square_over_the_variance():
    # Turned by 0.1 rad about down, with a standard deviation of 0.05 rad: (0.1 / 0.05)^2.
    half = 0.05
    columns = {f"t.truth.q[{i + 1}]": np.full(3, v) for i, v in enumerate((np.cos(half), 0, 0, np.sin(half)))}
    columns |= {f"f.att.q[{i + 1}]": np.full(3, v) for i, v in enumerate((1.0, 0, 0, 0))} | {
        f"f.att.sigma[{i}]": np.full(3, 0.05) for i in (1, 2, 3)
    }
    columns |= {f"f.cov.P[{i},{j}]": np.full(3, 0.05**2 * (i == j)) for i in (1, 2, 3) for j in range(i, 4)}
    columns["f.align.started"] = np.array([0.0, 1.0, 1.0])
    (estimate,) = estimates(Run(np.arange(3.0), columns, {}, {"components": {"t": {}, "f": {}}}))
    np.testing.assert_allclose(estimate.nees, [np.nan, 4.0, 4.0], rtol=1e-12)
    np.testing.assert_allclose(estimate.error_rad[1:], [[0, 0, 0.1]] * 2, atol=1e-15)


def test_held_samples_are_counted_once(run):
    estimate = estimates(run)[0]
    assert len(estimate.sampled("accel")) == run["hekf.count.accel_used"][-1]
    assert len(measured_field(run)) == run["sensor.mag.sample"][-1]


def test_a_run_without_truth_or_filters_has_only_the_panels_that_fit(run, tmp_path):
    names = {name for name in run.columns if not name.startswith("turntable.")}
    about = run.about | {"components": {c: v for c, v in run.about["components"].items() if c != "turntable"}}
    untrue = Run(run.t_s, {name: run[name] for name in names}, run.units, about)
    assert {"error", "nees"} == {p.name for p in ATTITUDE_PANELS} - {p.name for p in PANELS if p.applies(untrue)}
    assert write_report(untrue, tmp_path / "untrue.html")
    try:
        only = simulate(make_system(tmp_path / "only", {"turntable": "Turntable"}, []), stop_s=1)
    except HnavError as error:
        pytest.skip(str(error))
    assert write_report(only, tmp_path / "only.html") == ["timing"]
    assert write_pictures(only, tmp_path) == []


def test_a_caller_can_add_a_panel(run, tmp_path):
    from plotly import graph_objects as go

    from hnav.reports.panels import panel

    @panel("own", "A panel of one's own", "How to read it.", lambda run: "turntable" in run.components)
    def own(run: Run) -> go.Figure:
        return go.Figure(go.Scatter(x=run.t_s, y=run["turntable.truth.rate[3]"]))

    assert write_report(run, tmp_path / "report.html", [timing_panel, own]) == ["timing", "own"]
    assert 'id="plot-own"' in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_pictures_are_written(run, tmp_path):
    files = write_pictures(run, tmp_path / "new")
    assert [f.name for f in files] == ["attitude.png", "bias.png", "error.png"]
    assert all(f.read_bytes()[:4] == b"\x89PNG" for f in files)
    (tmp_path / "file").touch()
    with pytest.raises(HnavError, match="cannot write"):
        write_report(run, tmp_path / "file" / "report.html")


def test_the_command_says_where_the_page_lies(run, tmp_path):
    write_run(run, tmp_path)
    done = hnav("report", str(tmp_path), "--pictures", str(tmp_path / "pictures"))
    assert done.returncode == 0
    assert "report.html" in done.stdout and "error.png" in done.stdout
    assert (tmp_path / "report.html").stat().st_size > 1e6


def test_chromium_renders_every_panel_without_an_error_or_a_request(page, tmp_path):
    document, console, initiators = browse(page, tmp_path)
    assert not console
    assert not initiators
    assert len(re.findall(r'<div id="plot-\w+" class="plotly-graph-div js-plotly-plot"', document)) == len(PLOTS)
    assert document.count('class="main-svg"') >= len(PLOTS)


def test_chromium_reports_errors_and_requests(tmp_path):
    page = tmp_path / "bad.html"
    page.write_text('<img src="http://127.0.0.1:9/x.png"><script>nothing()</script>')
    _, console, initiators = browse(page, tmp_path)
    assert any("nothing is not defined" in line for line in console)
    assert initiators


def test_the_certificate_beside_a_run_has_a_panel(run, tmp_path):
    write_run(run, tmp_path)
    bare = read_run(tmp_path)
    assert "certificate" not in [p.name for p in PANELS if p.applies(bare)]
    (tmp_path / "certificate.json").write_text(
        '{"certified": false, "reason": "errors <grow>", "rate_1_s": 0.125, "region_deg": null}'
    )
    certified = read_run(tmp_path)
    assert "certificate" in write_report(certified, tmp_path / "report.html")
    shown = next(p for p in PANELS if p.name == "certificate").draw(certified)
    assert re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td>", shown) == [
        ("verdict", "not certified: errors &lt;grow&gt;"), ("rate_1_s", "0.125 1/s"),
    ]  # fmt: skip
