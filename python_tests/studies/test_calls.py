"""Random calls on archives: none breaks a promise, and a broken one is seen."""

import subprocess

import fmpy
import pytest

from hnav.cli.words import UsageError
from hnav.fmi.fmus import fmu_path
from studies.calls.study import Case, built, counts_of, plan_of

ARCHIVES = [("Ahrs", 2, "CS"), ("AhrsArrays", 3, "ME"), ("InsClocks", 3, "CS"), ("Gnss", 3, "CS"), ("Observer", 2, "ME")]


@pytest.fixture(scope="module")
def program():
    return built()


def case_of(name: str, version: int, kind: str) -> Case:
    return Case(fmu_path(name, version), version, kind)


@pytest.mark.parametrize(("name", "version", "kind"), ARCHIVES)
def test_random_calls_break_nothing(program, name, version, kind):
    counts = counts_of(program, case_of(name, version, kind), 7, 0.3)
    assert counts.broken == []
    assert 0 < counts.ok < counts.calls
    assert counts.longest_s < 1


def test_a_plan_that_declares_too_much_is_noticed(program, tmp_path):
    """The roll of an AHRS before its first sample is no enumeration between 7 and 8."""
    case = case_of("Ahrs", 2, "CS")
    description = fmpy.read_model_description(str(case.archive))
    fmpy.extract(str(case.archive), tmp_path)
    lines = plan_of(description, case, tmp_path).splitlines()
    lying = [" ".join([*line.split()[:4], "7", "8"]) if line.split()[1:3] == ["e", "o"] else line for line in lines]
    assert lying != lines
    (tmp_path / "plan.txt").write_text("\n".join(lying))
    binary = tmp_path / "binaries" / "linux64" / f"{description.coSimulation.modelIdentifier}.so"
    done = subprocess.run([program, binary, tmp_path / "plan.txt", "1", "1"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "an enumeration outside its values" in done.stdout


def test_an_archive_whose_binary_cannot_be_run_is_an_error(program, tmp_path):
    other = tmp_path / "Ahrs.fmu"
    other.write_bytes(fmu_path("Ahrs", 2).read_bytes())
    with pytest.raises(UsageError, match=r"Ahrs\.fmu: .*no file|no plan|cannot open"):
        counts_of(program, Case(other, 3, "CS"), 1, 0.1)
