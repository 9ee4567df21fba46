"""Output of the command line in a terminal, in a pipe and with --quiet; completion in a shell."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from command_line import hnav, hnav_process
from hnav.cli.app import COMMANDS, app
from hnav.cli.filter import infeasible_gamma
from hnav.cli.words import MISTYPED
from hnav.filters.options import FILTERS, option_table
from hnav.systems.ssp_reader import known_systems, read_system, system_path


def named(lines: list[str], filter: str) -> list[str]:
    """Names of options in the order of the lines."""
    return [word for line in lines for word in re.findall(r"^\s*(\w+)", line) if word in option_table(filter)]


@pytest.fixture
def terminal(monkeypatch):
    def of(columns: int) -> None:
        monkeypatch.setenv("COLUMNS", str(columns))
        monkeypatch.setenv("FORCE_COLOR", "1")

    return of


def completed(words: str) -> list[str]:
    """Completions of bash for the last word."""
    code = "import sys\nfrom hnav.cli.app import main\nmain([])"
    asked = {"COMP_WORDS": words, "COMP_CWORD": str(words.count(" ")), "_HNAV_COMPLETE": "complete_bash"}
    done = subprocess.run([sys.executable, "-c", code], env=os.environ | asked, capture_output=True, text=True, check=False)
    return done.stdout.split()


# ------------------------------------------------------------------------------------------------ the whole


def test_the_overview_and_the_version_load_no_command():
    code = """
import sys
from types import SimpleNamespace
from hnav.cli.app import main
try:
    main(["--version"])
except SystemExit:
    pass
print(sorted({"numpy", "pandas", "matplotlib", "fmpy", "scipy", "plotly", "rich"} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_without_words_the_commands_and_the_exit_codes_are_shown():
    done = hnav()
    assert done.returncode == 0
    assert all(re.search(rf"\b{name}\b", done.stdout) for name in COMMANDS)
    assert "Exit codes" in done.stdout and "130" in done.stdout


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself_and_can_be_quiet(name):
    for option in ("--help", "-h"):
        done = hnav(name, option)
        assert done.returncode == 0 and "--quiet" in done.stdout
        assert f"hnav {name}" in done.stdout


@pytest.mark.parametrize("arguments, message", [
    (["filtre"], "there is no command filtre: did you mean filter?"),
    (["xyzzy"], "there is no command xyzzy: there are filter, check"),
    (["filter", "--nosuch"], "no such option: --nosuch"),
    (["simulate"], "hnav simulate --help"),
    (["--nosuch"], "hnav --help"),
    (["montecarlo", "turntable", "--runs", "many"], "--runs"),
])  # fmt: skip
def test_words_that_are_no_command_are_answered_in_one_line(arguments, message):
    done = hnav(*arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert message in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_what_is_mistyped_is_an_error_of_the_parser():
    with pytest.raises(MISTYPED):
        app(["--nosuch"], standalone_mode=False)


# ------------------------------------------------------------------------------------------------ options


@pytest.mark.parametrize("filter", FILTERS)
def test_all_options_are_listed_those_to_look_at_first_at_the_head(filter):
    lines = hnav("options", "--filter", filter).stdout.splitlines()
    table = option_table(filter)
    found = named(lines, filter)
    assert sorted(found) == sorted(info.attribute for info in table.values()) and len(found) == len(lines)
    advanced = [table[name].advanced for name in found]
    assert advanced == sorted(advanced) and not advanced[0]


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_no_name_of_an_option_is_cut_and_no_line_of_text_is_longer_than_the_terminal(terminal, columns):
    terminal(columns)
    plain = re.sub(r"\x1b\[[\d;]*m", "", hnav_process("options").stdout).splitlines()
    assert set(named(plain, "ahrs")) == set(option_table("ahrs"))
    assert all(len(line) <= columns for line in plain if " = " not in line)


@pytest.mark.parametrize("words", [["gate"], ["GATE", "nis"], ["rad/s"], ["backward"], ["heading", "sigma"]])
def test_words_leave_the_options_that_have_all_of_them(words):
    whole = hnav("options", "--json").stdout
    some = [entry["name"] for entry in json.loads(hnav("options", *words, "--json").stdout)]
    entries = {entry["name"]: entry for entry in json.loads(whole)}
    assert 0 < len(some) < len(entries)
    assert set(named(hnav("options", *words).stdout.splitlines(), "ahrs")) == set(some)
    for name, entry in entries.items():
        shown = json.dumps({key: entry.get(key) for key in ("name", "group", "unit", "description", "choices")}).lower()
        assert (name in some) == all(word.lower() in shown for word in words), name


def test_a_word_that_no_option_has_is_one_line():
    done = hnav("options", "xyzzy")
    assert done.returncode == 2 and "xyzzy" in done.stderr and done.stderr.count("\n") == 1


def test_few_options_come_with_the_reason_of_their_default(terminal):
    terminal(100)
    info = option_table("ahrs")["mag_gate_share"]
    assert info.reason and info.reason in " ".join(hnav("options", "mag_gate_share").stdout.split())


# ------------------------------------------------------------------------------------------------ systems


@pytest.fixture
def systems():
    known = known_systems()
    if not known:
        pytest.skip("no system is built")
    return known


def test_every_system_is_listed_with_its_scenarios_and_grades(systems):
    listed = json.loads(hnav("systems", "--json").stdout)
    assert [entry["name"] for entry in listed] == sorted(systems)
    for entry in listed:
        with read_system(system_path(entry["name"])) as system:
            assert list(entry["scenarios"]) == list(system.scenarios) and list(entry["grades"]) == list(system.grades)
            assert list(entry["components"]) == list(system.components)
        shown = hnav("systems", entry["name"]).stdout
        assert all(re.search(rf"^ +{name} ", shown, re.MULTILINE) for name in [*entry["scenarios"], *entry["grades"]])
        assert entry["description"] in shown


def test_without_systems_it_is_said_how_to_make_them(monkeypatch, tmp_path):
    monkeypatch.setenv("HNAV_SYSTEMS", str(tmp_path))
    done = hnav("systems")
    assert done.returncode == 2 and "./run fmus" in done.stderr and done.stderr.count("\n") == 1


# ------------------------------------------------------------------------------------------------ pipes and quiet


def test_a_pipe_gets_no_blank_line(systems):
    for arguments in (["options"], ["options", "gate"], ["systems"], *(["systems", name] for name in systems)):
        assert all(line.strip() for line in hnav(*arguments).stdout.splitlines()), arguments


def test_quiet_changes_what_is_printed_and_not_what_is_written(motion, tmp_path):
    m = motion.recording
    path = tmp_path / "flight.csv"
    table = np.column_stack([m.t_s, m.rate_b_rad_s, m.force_b_m_s2, m.field_b_tesla])
    np.savetxt(path, table, delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")
    loud, quiet = (hnav("filter", path, "--out", tmp_path / f"{i}.csv", *extra) for i, extra in enumerate([[], ["--quiet"]]))
    assert loud.returncode == quiet.returncode == 0
    assert loud.stdout and not quiet.stdout
    assert (tmp_path / "0.csv").read_bytes() == (tmp_path / "1.csv").read_bytes()
    refused = hnav("filter", path, "--out", path, "-q")
    assert refused.returncode == 2 and refused.stderr
    assert hnav("filter", path, "--out", tmp_path / "2.csv").stdout, "the next command speaks again"


# ------------------------------------------------------------------------------------------------ completion


@pytest.mark.parametrize("words, offered", [
    ("hnav s", {name for name in COMMANDS if name.startswith("s")}),
    ("hnav filter --filter ", {*FILTERS, "ins"}),
    ("hnav filter --filter ins --set start_place=", {"start_place=fix", "start_place=given"}),
    ("hnav options --filter hr", {"hrekf"}),
    ("hnav filter --set gyro_hold=", {"gyro_hold=forward", "gyro_hold=backward", "gyro_hold=instant"}),
    ("hnav filter --set xyzzy", set()),
    ("hnav simulate nosuch --scenario ", set()),
])  # fmt: skip
def test_a_shell_completes_names(words, offered):
    assert set(completed(words)) == offered


def test_a_shell_completes_systems_and_what_they_have(systems):
    assert set(completed("hnav simulate ")) == set(systems)
    if "turntable" in systems:
        with read_system(system_path("turntable")) as system:
            assert set(completed("hnav simulate turntable --scenario ")) == set(system.scenarios)
            assert set(completed("hnav montecarlo turntable --grade ")) == set(system.grades)


def test_a_gamma_that_is_infeasible_at_most_corrections_is_said_once():
    def counts(raised: int, corrections: int) -> dict[str, int]:
        return {"gamma_raised": raised, "corrections": corrections}

    (line,) = infeasible_gamma(counts(90, 100))
    assert "90 of 100 corrections" in line and "larger --set gamma=" in line
    assert not infeasible_gamma(counts(10, 100)) and not infeasible_gamma(counts(0, 0))
