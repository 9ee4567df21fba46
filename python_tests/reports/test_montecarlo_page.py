"""The page about many runs: figures of the table, the worst runs first, and the command that opens them."""

import pandas as pd
import pytest

from browser import browse
from command_line import hnav
from hnav.systems.montecarlo import COMMAND, Job, simulate_command, write_table

pytest.importorskip("plotly", reason="plotly is not installed: no pages")
pytest.importorskip("pyarrow", reason="pyarrow is not installed: no tables of runs")


@pytest.fixture
def runs(tmp_path):
    rows = [
        {"scenario": "turns", "seed": seed, "filter": "ahrs", "failure": "", "mse_deg2": float(seed) ** 2, "heading_ready_s": 8.0}
        for seed in range(1, 21)
    ]
    table = pd.DataFrame([*rows, {"scenario": "turns", "seed": 21, "filter": "", "failure": "the step is too long"}])
    job = Job("turntable", "turns", 1, grade="consumer", settings={"a.b": "c d"}, stop_s=20.0)
    table.attrs[COMMAND] = simulate_command(job)
    write_table(table, tmp_path / "runs.parquet")
    return tmp_path / "runs.parquet"


def test_the_page_has_the_figures_and_the_commands_of_the_worst_runs(runs, tmp_path):
    done = hnav("report", runs)
    assert done.returncode == 0 and "distribution, table, worst" in done.stdout
    page = runs.with_suffix(".html")
    document, console, asked = browse(page, tmp_path)
    assert not console and not asked
    assert "turns, seed 21 failed: the step is too long" in document
    for cell in ("10.5", "19.1", "20"):  # median, 95 %, worst of 1 to 20 deg
        assert f"<td>{cell}</td>" in document
    opened = "hnav simulate turntable --grade consumer --stop 20.0 --set 'a.b=c d' --scenario turns --seed 20 --out seed_20"
    assert f"<td>{opened} &amp;&amp; hnav report seed_20</td>" in document
    assert document.index("seed_20") < document.index("seed_19") < document.index("seed_12")
    assert "seed_10" not in document


def test_runs_that_all_failed_have_no_page(runs):
    table = pd.read_parquet(runs)
    write_table(table[table["failure"] != ""], runs)
    done = hnav("report", runs)
    assert done.returncode == 2 and "no run came to its end" in done.stderr
    assert not runs.with_suffix(".html").exists()
