"""hnav filter of many recordings: the tables of each alone, a row about each, and a command that was killed goes on."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

import recorded
from browser import Tab
from command_line import hnav
from hnav.cli.filter import expanded
from hnav.cli.many import UNFINISHED, table_names
from hnav.cli.words import UsageError
from motion import tilted_motion


@pytest.fixture(scope="module")
def logs(tmp_path_factory) -> Path:
    """Five recordings, one of them none, one in g."""
    folder = tmp_path_factory.mktemp("logs")
    for seed in range(3):
        recorded.house(folder, tilted_motion(15, seed=seed).recording).rename(folder / f"walk{seed}.csv")
    (folder / "bad.csv").write_text("a,b\n1,2\n")
    in_g = (folder / "walk0.csv").read_text().splitlines()
    rows = [
        ",".join([*row[:4], *(repr(float(v) / 9.81) for v in row[4:7]), *row[7:]])
        for row in (line.split(",") for line in in_g[1:])
    ]
    (folder / "walk_g.csv").write_text("\n".join([in_g[0], *rows]) + "\n")
    return folder


@pytest.fixture(scope="module")
def alone(logs, tmp_path_factory) -> dict[str, bytes]:
    """The tables of the good ones, each by a command of its own. The head names the recording as it was given."""
    out = tmp_path_factory.mktemp("alone") / "one.csv"
    found = {}
    for seed in range(3):
        assert hnav("filter", logs / f"walk{seed}.csv", "--out", out).returncode == 0
        found[f"walk{seed}.csv"] = out.read_bytes()
    return found


def tables(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.glob("walk*.csv")}


def test_many_recordings_give_the_tables_of_each_alone(logs, alone, tmp_path):
    out = tmp_path / "out"
    done = hnav("filter", f"{logs}/*.csv", "--out", out)
    assert done.returncode == 0 and "3 of 5 recordings" in done.stdout and tables(out) == alone
    index = pd.read_csv(out / "index.csv", keep_default_na=False).set_index("recording")
    assert list(index.index) == sorted(str(path) for path in logs.glob("*.csv"))
    assert "no header" in index.loc[f"{logs}/bad.csv", "failure"]
    assert index.loc[f"{logs}/walk0.csv", "read as"].startswith("csv: gyro rad/s assumed, accel m/s2 assumed, mag T assumed")
    assert "this looks like g; use --accel-unit g" in index.loc[f"{logs}/walk_g.csv", "failure"]
    assert index.loc[f"{logs}/walk1.csv", "answer"].startswith("1500 rows to")
    page = (out / "index.html").read_text()
    assert 'href="walk2.csv"' in page and "<dd>5</dd>" in page and "<dd>2</dd>" in page
    assert not (out / UNFINISHED).exists()
    forced = hnav("filter", *sorted(logs.glob("walk*.csv")), "--force", "--out", tmp_path / "forced")
    assert forced.returncode == 0 and "4 of 4 recordings" in forced.stdout


def test_the_index_page_can_be_read_on_a_telephone(logs, tmp_path):
    hnav("filter", f"{logs}/*.csv", "--out", tmp_path / "out")
    tab = Tab((tmp_path / "out" / "index.html").as_uri(), tmp_path, width=390)
    try:
        end_s = time.monotonic() + 60
        while "no header" not in str(tab.value("document.body.innerText")) and time.monotonic() < end_s:
            time.sleep(0.05)
        assert tab.value("document.querySelector('.scroll').scrollWidth <= document.querySelector('.scroll').clientWidth") is True
    finally:
        tab.close()


def test_a_command_that_was_killed_twice_goes_on_to_the_same_tables(logs, alone, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "hnav", "filter", f"{logs}/*.csv", "--out", str(out)]
    for least in (1, 2):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        begin = time.monotonic()
        while process.poll() is None and time.monotonic() - begin < 60:
            if (out / UNFINISHED).exists() and (out / UNFINISHED).read_bytes().count(b"\n") > least:
                process.send_signal(signal.SIGKILL)
            time.sleep(0.005)
        process.wait()
    done = hnav("filter", f"{logs}/*.csv", "--out", out)
    assert done.returncode == 0 and "3 of 5 recordings" in done.stdout and tables(out) == alone
    # What is begun with other options is another work.
    (tmp_path / "other").mkdir()
    begun = tmp_path / "other" / UNFINISHED
    begun.write_bytes(b"something else\n")
    refused = hnav("filter", f"{logs}/*.csv", "--out", tmp_path / "other")
    assert refused.returncode == 2 and "is something else" in refused.stderr


@pytest.mark.slow
def test_a_cluster_gives_the_same_tables(logs, alone, tmp_path):
    distributed = pytest.importorskip("distributed", reason="distributed is not installed: one worker only")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
        done = hnav("filter", f"{logs}/*.csv", "--out", tmp_path / "out", "--scheduler", cluster.scheduler_address)
    assert done.returncode == 0 and "3 of 5 recordings" in done.stdout and tables(tmp_path / "out") == alone


def test_what_cannot_be_done_with_many_is_said(logs, tmp_path):
    for given, said in (
        ((f"{logs}/*.csv",), "--out DIR"), ((f"{logs}/*.csv", "--out", tmp_path / "o", "--report", tmp_path / "r.html"), "no --report"),
        ((f"{logs}/*.csv", "--out", tmp_path / "o.csv"), "it is a folder"), ((f"{logs}/*.csv", "--out", tmp_path / "o", "--workers", 0), "--workers 0: at least 1"),
        ((logs / "walk0.csv", "--out", tmp_path / "o.doc"), "o.doc: the forms are .csv, .parquet"),
        ((f"{logs}/*.nothing", "--out", tmp_path / "o"), "no file matches it"), ((f"{logs}/b*.csv", "--out", tmp_path / "o"), "no recording could be filtered"),
    ):  # fmt: skip
        done = hnav("filter", *given)
        assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1, done.stderr
    with pytest.raises(UsageError, match="no file matches"):
        expanded(["nothing*"])


def test_tables_have_the_names_of_their_recordings_as_far_as_these_differ():
    paths = [Path("a/walk.csv"), Path("b/walk.csv"), Path("b/run.csv")]
    assert table_names(paths) == ["a_walk.csv", "b_walk.csv", "run.csv"]
    assert table_names([Path("walk.csv"), Path("walk.txt")]) == ["walk_0.csv", "walk_1.csv"]
