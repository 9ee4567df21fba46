"""The page about a recording: whole, small, right, and rendered by a browser."""

import re
import subprocess
import sys
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from browser import LOADED, browse
from command_line import hnav
from hnav import Filter, __version__
from hnav.cli.report import beside
from hnav.errors import HnavError
from hnav.io.recordings import Recording
from hnav.reports.recording_run import recording_run
from hnav.rotations import rotation_error_rad
from motion import tilted_motion

pytest.importorskip("plotly", reason="plotly is not installed: no report")
from plotly.offline import get_plotlyjs

from hnav.reports.colours import BLUE, FAINT, INK
from hnav.reports.page import AXIS, LAYOUT, section
from hnav.reports.recording_page import SHOWN, write_recording_report
from hnav.reports.recording_view import field_n, view
from hnav.reports.strength_panel import strength_panel

EPOCH_S = 1.7e9


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Its reference goes to east-north-up axes, as those of recordings do."""
    made = tilted_motion(60).recording
    run = Filter("ahrs", gyro_hold="forward", navigation_frame="enu").run(
        made.t_s, made.rate_b_rad_s, made.force_b_m_s2, made.field_b_tesla
    )
    return replace(made, name="a <walk>", t_s=EPOCH_S + made.t_s, reference_q_nb=run.q_nb)


def filtered(recording: Recording, **options):
    return Filter("ahrs", gyro_hold="forward", **options).run(
        recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla
    )


@pytest.fixture(scope="module")
def page(recording, tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "walk.html"
    run = filtered(recording, navigation_frame="enu")
    write_recording_report(recording_run(run, recording, ["warning: median |force| 1.00: < this looks like g"]), file)
    return file


def test_the_page_stands_alone_and_says_what_it_is_of(page):
    text = page.read_text(encoding="utf-8")
    assert not LOADED.search(text)
    for said in (
        "<h1>a &lt;walk&gt;</h1>", "median |force| 1.00: &lt; this looks like g", "2023-11-14 22:13:20 UTC", "100 Hz, 6000 samples",
        "navigation_frame", __version__, "heading ready", "gyro bias x, y, z", "RMS against optics",
    ):  # fmt: skip
        assert said in text
    assert re.findall(r'<section id="([\w-]+)">', text) == [
        "summary", *(name for name in SHOWN if name != "health"), "observability",
    ]  # fmt: skip


def test_frames_are_those_of_the_run_and_the_reference_follows(recording):
    """The same attitude in both frames: the comparison does not depend on the frame."""
    errors, fields = {}, {}
    for frame in ("ned", "enu"):
        run = recording_run(filtered(recording, navigation_frame=frame), recording)
        errors[frame] = rotation_error_rad(run.result.q_nb, run.reference_q_nb)
        fields[frame] = field_n(run)
    known = np.isfinite(errors["enu"]).all(axis=1)
    np.testing.assert_allclose(errors["ned"][known], errors["enu"][known][:, [1, 0, 2]] * [1, 1, -1], atol=1e-9)
    np.testing.assert_allclose(fields["ned"][known][:, 2], fields["enu"][known][:, 2], atol=1e-12)
    # The sensor was simulated with 20 microtesla north and 45 down.
    np.testing.assert_allclose(np.median(fields["ned"][3000:], axis=0), [2e-5, 0, 4.5e-5], atol=1.5e-6)
    # The reference was made of the same samples with other time stamps.
    assert np.abs(errors["enu"][known]).max() < 0.01


def test_strength_and_dip_are_those_of_the_field(recording):
    run = view(recording_run(filtered(recording), recording))
    said = section(strength_panel, run)
    assert f"median {np.hypot(20, 45):.1f}"[:-1] in said
    assert float(re.search(r"dip: median ([\d.]+) deg", said)[1]) == pytest.approx(np.degrees(np.arctan2(45, 20)), abs=0.5)


def test_a_mounted_sensor_is_turned_before_its_field_is(recording):
    mounted = recording_run(filtered(recording, q_body_sensor=(0, 1, 0, 0)), recording)
    plain = recording_run(filtered(recording), recording)
    late = slice(4000, None)
    np.testing.assert_allclose(np.linalg.norm(field_n(mounted)[late], axis=1), np.linalg.norm(field_n(plain)[late], axis=1))
    dip = [np.arctan2(f[:, 2], np.hypot(f[:, 0], f[:, 1])) for f in (field_n(mounted)[late], field_n(plain)[late])]
    assert np.degrees(np.median(dip[0])) == pytest.approx(np.degrees(np.median(dip[1])), abs=1)


def test_a_run_without_its_recording_has_a_page_too(recording, tmp_path):
    run = filtered(recording)
    run.report(tmp_path / "alone.html")
    assert write_recording_report(recording_run(run), tmp_path / "alone.html") == [
        "body", "attitude", "states", "bias", "nis", "observability",
    ]  # fmt: skip
    run.accepted = None
    assert "states" in write_recording_report(recording_run(run), tmp_path / "alone.html")
    with pytest.raises(HnavError, match="has other rows than the run"):
        run.report(tmp_path / "other.html", recording.cropped(5))


def test_what_is_not_plausible_stands_at_the_head(recording, tmp_path):
    in_g = replace(recording, force_b_m_s2=recording.force_b_m_s2 / 9.81)
    filtered(in_g).report(tmp_path / "g.html", in_g)
    assert re.search(
        r'<p class="warning">warning: accel: [^<]*this looks like g[^<]*accel_unit', (tmp_path / "g.html").read_text()
    )
    assert 'class="warning"' not in _header(recording, tmp_path)
    table = np.column_stack([in_g.t_s, in_g.rate_b_rad_s, in_g.force_b_m_s2, in_g.field_b_tesla])
    np.savetxt(tmp_path / "g.csv", table, fmt="%.17g", delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    done = hnav("report", tmp_path / "g.csv", "--force", "--out", tmp_path / "g.html")
    assert done.returncode == 0 and "use --accel-unit g" in done.stderr
    assert re.search(r'<p class="warning">warning: accel: [^<]*use --accel-unit g', (tmp_path / "g.html").read_text())
    assert hnav("report", tmp_path / "g.csv", "--strict").returncode == 2
    assert hnav("report", tmp_path / "g.csv", "--accel-unit", "g", "--strict").returncode == 0


def _header(recording, tmp_path) -> str:
    filtered(recording).report(tmp_path / "good.html", recording)
    return (tmp_path / "good.html").read_text()


@pytest.mark.parametrize("rows", [1, 2, 30])
def test_a_recording_of_few_rows_has_a_page(recording, tmp_path, rows):
    few = Recording(
        "few", *(a[:rows] for a in (recording.t_s, recording.rate_b_rad_s, recording.force_b_m_s2, recording.field_b_tesla))
    )
    filtered(few).report(tmp_path / "few.html", few)
    assert "<h1>few</h1>" in (tmp_path / "few.html").read_text(encoding="utf-8")


def test_a_run_without_an_attitude_says_so(tmp_path):
    run = Filter("ahrs").run(np.arange(200) * 0.01, np.zeros((200, 3)))
    run.report(tmp_path / "none.html")
    assert "none: the filter did not start" in (tmp_path / "none.html").read_text(encoding="utf-8")


def test_sixty_thousand_rows_are_a_small_page(tmp_path):
    made = tilted_motion(600).recording
    assert len(made.t_s) == 60_000
    filtered(made, navigation_frame="enu").report(tmp_path / "long.html", replace(made, reference_q_nb=made.reference_q_nb))
    assert (tmp_path / "long.html").stat().st_size - len(get_plotlyjs().encode()) < 1.5e6


def test_plot_is_a_picture_that_a_notebook_shows(recording):
    figure = filtered(recording, navigation_frame="enu").plot(recording)
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert [axes.get_title(loc="left") for axes in figure.axes][1].startswith("Heading against the optics")
    assert filtered(recording).plot().axes[0].get_title(loc="left").endswith("body to north-east-down")


def test_the_commands_write_the_page(recording, tmp_path):
    made = recording.cropped(5)
    table = np.column_stack([made.t_s, made.rate_b_rad_s, made.force_b_m_s2, made.field_b_tesla * 1e6])
    np.savetxt(tmp_path / "walk.csv", table, fmt="%.17g", delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    done = hnav("report", tmp_path / "walk.csv", "--mag-unit", "uT")
    assert done.returncode == 0, done.stderr
    assert "500 rows to " in done.stdout and "walk.html" in done.stdout
    page = (tmp_path / "walk.html").read_text(encoding="utf-8")
    done = hnav("filter", tmp_path / "walk.csv", "--mag-unit", "uT", "--report", tmp_path / "same.html")
    assert done.returncode == 0, done.stderr
    assert "500 rows to " in done.stdout and "same.html" in done.stdout
    assert (tmp_path / "same.html").read_text(encoding="utf-8") == page
    done = hnav("filter", tmp_path / "walk.csv")
    assert done.returncode == 2 and "--out FILE.csv" in done.stderr and "--report" in done.stderr
    done = hnav("report", tmp_path / "walk.csv", "--pictures", tmp_path)
    assert done.returncode == 2 and "Run.plot" in done.stderr
    assert hnav("report", tmp_path / "walk.csv", "--out", tmp_path / "walk.csv").returncode == 2
    asked = ("--mag-unit", "uT", "--grade", "consumer", "--body", "hand", "--smooth", "--out", tmp_path / "smooth.html")
    assert hnav("report", tmp_path / "walk.csv", *asked).returncode == 0 and (tmp_path / "smooth.html").exists()


def test_what_is_not_asked_for_is_not_loaded(tmp_path):
    """The page does without Matplotlib and pandas; a run without the page and Plotly."""
    run = "import sys, numpy as np, hnav; r = hnav.Filter('ahrs').run(np.arange(9.0)); repr(r), r._repr_html_();"
    loaded = "print(*(m for m in ('plotly', 'matplotlib', 'pandas', 'scipy', 'h5py', 'fmpy') if m in sys.modules))"
    page = f"r.report({str(tmp_path / 'x.html')!r});"
    for steps, expected in ((run, set()), (run + page, {"plotly", "scipy"})):
        done = subprocess.run([sys.executable, "-c", steps + loaded], capture_output=True, text=True, check=True)
        assert set(done.stdout.split()) == expected


@pytest.mark.parametrize("run", [
    "hnav.Filter('ahrs').run(np.arange(9.0))", "hnav.Ins('consumer').run_recording(hnav.Recording('still', np.arange(9.0)/100, *2*[np.ones((9, 3))]))",
])  # fmt: skip
def test_a_page_without_plotly_says_how_to_install_it(run):
    code = f"import sys; sys.modules['plotly'] = None; import numpy as np, hnav; {run}.report('x.html')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert "HnavValueError" in last and "python -m pip install plotly" in last


def test_chromium_renders_the_page_of_a_recording(page, tmp_path):
    document, console, initiators = browse(page, tmp_path)
    assert not console
    assert not initiators
    plots = [*(name for name in SHOWN if name not in ("body", "health")), "observability"]
    assert re.findall(r'<div id="plot-(\w+)" class="plotly-graph-div js-plotly-plot"', document) == plots
    assert re.search(r'<output id="body-says">[\d.]+ s   roll -?[\d.]+°  pitch -?[\d.]+°  heading [\d.]+°</output>', document)
    assert 'aria-label="Zoom"' in document and 'aria-label="Share' not in document  # which would upload the recording


# The browser is given a time of its own, in which frames come or not: here they do.
OPERATE = """<script>requestAnimationFrame = call => setTimeout(() => call(performance.now()), 16);
addEventListener("load", () => {
  const said = [], says = document.getElementById("body-says"), time = document.getElementById("body-time");
  const canvas = document.getElementById("body-canvas"), button = document.getElementById("body-play");
  const note = () => said.push(says.textContent.split(" ")[0]);
  time.value = 0; time.dispatchEvent(new Event("input")); note();
  const drawn = canvas.toDataURL();
  time.value = time.max; time.dispatchEvent(new Event("input")); note();
  said.push(canvas.toDataURL() !== drawn);
  document.getElementById("body-speed").value = 100;
  time.value = time.max - 2; time.dispatchEvent(new Event("input"));
  button.click(); said.push(button.textContent);
  const waiting = setInterval(() => {
    if (button.textContent !== "play") return;
    clearInterval(waiting); note();
    document.body.append(Object.assign(document.createElement("pre"), { id: "said", textContent: said.join("|") }));
  }, 50);
});</script>"""


def test_slider_and_play_turn_the_body(page, tmp_path):
    operated = tmp_path / "operated.html"
    operated.write_text(page.read_text(encoding="utf-8").replace("</body></html>", f"{OPERATE}</body></html>"), encoding="utf-8")
    document, console, _ = browse(operated, tmp_path)
    assert not console
    # Begin, end, another picture; played, it stops at the end.
    assert re.search('<pre id="said">(.*?)</pre>', document)[1] == "0.00|59.99|true|stop|59.99"


POINT = """<script>addEventListener("load", () => setTimeout(async () => {
  const [first, ...others] = figures.filter(div => meta(div).time), box = first.getBoundingClientRect(), axis = first._fullLayout.xaxis;
  const clientX = box.left + axis._offset + axis._length / 4;
  first.dispatchEvent(new PointerEvent("pointermove", { clientX, clientY: box.top + 60 }));
  const lines = document.querySelectorAll(".cursor"), seen = [...lines].filter(line => line.style.display === "");
  const said = [document.getElementById("body-says").textContent.split(" ")[0], lines.length - others.length, seen.length - others.length];
  await Plotly.relayout(first, { "xaxis.range": [10, 20] });
  while (isLinking) await new Promise(done => setTimeout(done, 10));
  said.push(...others.map(div => div._fullLayout.xaxis.range));
  document.body.append(Object.assign(document.createElement("pre"), { id: "said", textContent: said.join("|") }));
}, 100));</script>"""


def test_all_figures_show_the_moment_and_the_range_of_one(page, tmp_path):
    pointed = tmp_path / "pointed.html"
    pointed.write_text(page.read_text(encoding="utf-8").replace("</body></html>", f"{POINT}</body></html>"), encoding="utf-8")
    document, console, _ = browse(pointed, tmp_path)
    assert not console
    said = re.search('<pre id="said">(.*?)</pre>', document)[1].split("|")
    assert float(said[0]) == pytest.approx(15, abs=0.1) and said[1:3] == ["1", "1"] and set(said[3:]) == {"10,20"}


def test_a_dark_screen_gets_light_ink():
    """Each colour of ink and paper that the layout and the panels use has another for dark screens."""
    script = resources.files("hnav.reports").joinpath("screen.js").read_text(encoding="utf-8")
    table = dict(re.findall(r'"(#\w{6})": "(#\w{6})"', script))
    for colour in (INK, FAINT, BLUE, *re.findall(r"#\w{6}", str((LAYOUT, AXIS)))):
        assert colour in table, colour
        if colour in (INK, FAINT):
            assert int(table[colour][1:3], 16) > int(colour[1:3], 16)


def test_a_gate_says_nothing_before_its_first_sample(recording):
    late = replace(recording, field_b_tesla=recording.field_b_tesla.copy())
    late.field_b_tesla[:2000] = np.nan
    seen = view(recording_run(filtered(late), late))
    assert not seen["ahrs.gate.mag_ok"][:2000].any() and seen["ahrs.gate.mag_ok"][3000:].any()
    assert "gate.mag_ok" not in {name.partition(".")[2] for name in view(recording_run(filtered(late.cropped(15)))).columns}


def test_the_page_of_the_folder_that_one_is_in_lies_beside_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert beside(Path("."), ".html") == tmp_path.with_suffix(".html")
    assert beside(Path("walk.csv"), ".html") == Path("walk.html")
