"""The build of the mutated copy, what its tests reach, and whether they notice a mutant."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hnav.cli.words import UsageError
from hnav.places import CHECKOUT
from studies.mutants.mutated_copy import SWITCH
from studies.processes import fmi_headers, sundials_source

# Laws in Python: the filters beside those of the NumPy reference, what holds for every filter, and FMUs, which C++ tests do not have.
PYTHON_LAWS = (
    "python_tests/filters/test_attitude.py", "python_tests/filters/test_health.py",
    "python_tests/filters/test_ins.py", "python_tests/filters/test_ins_error_filter.py", "python_tests/filters/test_ins_field.py",
    "python_tests/filters/test_ins_smoother.py", "python_tests/twins/test_hrekf.py", "python_tests/twins/test_ins_error.py",
    "python_tests/twins/test_ins_twin.py",
    "python_tests/observer/test_bounds.py", "python_tests/observer/test_cosimulation_plants.py",
    "python_tests/observer/test_fmu_events.py", "python_tests/observer/test_fmu_plants.py",
    "python_tests/observer/test_large_plants.py", "python_tests/observer/test_live_plants.py",
    "python_tests/observer/test_observability.py", "python_tests/observer/test_plant_events.py",
    "python_tests/observer/test_plants_without_answers.py", "python_tests/observer/test_python_plants.py",
    "python_tests/observer/test_robust_law.py", "python_tests/observer/test_sigma_points.py",
    "python_tests/observer/test_smoothing.py", "python_tests/observer/test_stiff_plants.py",
    "python_tests/test_frozen_answers.py",
)  # fmt: skip
# It compiles the attitude filters once more.
LEFT_OUT = {"test_small"}
MEMORY_BYTES = 8 << 30  # of one program: a mutant may ask for more and more
MIN_TIME_S, TIMES = 10.0, 10.0  # an endless loop: so long, and so many times the time without a mutant


@dataclass(frozen=True)
class Test:
    """What is run on its own: a test of GoogleTest, a program, or a file of pytest."""

    command: tuple[str, ...]
    name: str  # empty: the whole program
    time_s: float = 0.0
    reached: frozenset[str] = frozenset()  # names of mutants

    @property
    def is_python(self) -> bool:
        return "pytest" in self.command


class Build:
    """The copy under a folder, built with one job."""

    def __init__(self, folder: Path):
        self.source, self.binary = folder / "source", folder / "build"

    def make(self) -> None:
        """Raises UsageError with the first error of the compiler."""
        flags = f"-O1 -w -DNDEBUG -include {SWITCH}"
        configure = [
            "cmake", "-S", str(self.source), "-B", str(self.binary), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
            f"-DCMAKE_CXX_FLAGS={flags}", "-DHNAV_BUILD_BENCH=OFF", "-DHNAV_BUILD_EXAMPLES=OFF",
            f"-DHNAV_SUNDIALS_SOURCE={sundials_source()}", f"-DHNAV_FMI_HEADERS={fmi_headers()}",
        ]  # fmt: skip
        for step in (configure, ["cmake", "--build", str(self.binary), "-j1", "--target", *self.targets()]):
            done = subprocess.run(step, capture_output=True, text=True, check=False)
            if done.returncode:
                said = done.stdout + done.stderr
                errors = re.findall(r"^.*error.*$", said, flags=re.MULTILINE | re.IGNORECASE) or said.strip().splitlines()[-1:]
                raise UsageError(f"the mutated copy cannot be built: {errors[0]}")

    def targets(self) -> list[str]:
        tests = [path.stem for path in sorted((self.source / "c_src/tests").glob("test_*.cpp")) if path.stem not in LEFT_OUT]
        return ["hnav", "random_streams", *tests, *(f"replay_{corpus.name}" for corpus in self.corpora())]

    def corpora(self) -> list[Path]:
        """Of the targets that need no FMI."""
        fuzz = self.source / "c_src/fuzz"
        return [fuzz / "corpus" / path.stem.removeprefix("fuzz_") for path in sorted(fuzz.glob("fuzz_*.cpp"))]

    def tests(self) -> Iterator[Test]:
        """All that there are, not yet run."""
        programs = self.binary / "c_src/tests"
        for program in sorted(programs.glob("test_*")):
            if program.is_file() and os.access(program, os.X_OK):
                yield from (Test((str(program),), name) for name in gtest_names(program))
        for corpus in self.corpora():
            yield Test((str(programs / f"replay_{corpus.name}"), str(corpus)), "")
        yield Test((str(programs / "random_streams"), "0", "100"), "")
        for file in PYTHON_LAWS:
            yield Test((sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", file), "")

    @property
    def library(self) -> Path:
        return self.binary / "c_src/libhnav.so"


def gtest_names(program: Path) -> list[str]:
    """SUITE.TEST of each test."""
    listed = subprocess.run([str(program), "--gtest_list_tests"], capture_output=True, text=True, check=True).stdout
    names, suite = [], ""
    for line in listed.splitlines():
        words = line.split("#")[0].strip()
        if line.startswith("  "):
            names.append(suite + words)
        elif words.endswith("."):
            suite = words
    return names


@dataclass(frozen=True)
class Run:
    """How a program ended. failed: empty when it passed."""

    failed: str
    time_s: float


def run(build: Build, command: tuple[str, ...], names: list[str], mutant: str, limit_s: float, reached: str = "") -> Run:
    """One program with one mutant on (empty: none), of GoogleTest with these tests alone."""
    words = [*command, *([f"--gtest_filter={':'.join(names)}", "--gtest_fail_fast", "--gtest_brief=1"] if any(names) else [])]
    environment = os.environ | {"HMUT": mutant, "HNAV_LIBRARY": str(build.library)}
    environment["PYTHONPATH"] = str(CHECKOUT / "python")
    if reached:
        environment["HMUT_REACHED"] = reached
    begin = time.monotonic()
    try:
        done = subprocess.run(
            words, capture_output=True, env=environment, timeout=limit_s, cwd=CHECKOUT, check=False, preexec_fn=limit_memory
        )
    except subprocess.TimeoutExpired:
        return Run("time-out", limit_s)
    return Run(how_it_failed(done, Path(command[0]).name), time.monotonic() - begin)


def limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def how_it_failed(done: subprocess.CompletedProcess[bytes], program: str) -> str:
    """The test that failed first; the signal where the program came to its end by one."""
    if done.returncode == 0:
        return ""
    said = (done.stdout + done.stderr).decode(errors="replace")
    test = re.search(r"^\[  FAILED  \] ([\w./]+)|^FAILED (\S+)|^ERROR (\S+)", said, flags=re.MULTILINE)
    if test:
        return next(name for name in test.groups() if name)
    return f"{program}: signal {-done.returncode}" if done.returncode < 0 else program


def with_reach(build: Build, test: Test) -> Test:
    """The test with its time and the mutants that it comes to. Raises UsageError when it fails without a mutant."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "reached"
        done = run(build, test.command, [test.name], "", 600.0, str(file))
        if done.failed:
            raise UsageError(f"without a mutant {done.failed} fails")
        numbers = frozenset(file.read_text().split()) if file.is_file() else frozenset[str]()
    return Test(test.command, test.name, done.time_s, numbers)


def trial(build: Build, tests: list[Test], mutant: str) -> str:
    """What notices the mutant: a test, a signal or time-out. Empty: nothing does."""
    by_program: dict[tuple[str, ...], list[Test]] = {}
    for test in tests:
        if mutant in test.reached:
            by_program.setdefault(test.command, []).append(test)
    # The cheapest first; Python last.
    for command, reaching in sorted(by_program.items(), key=lambda item: (item[1][0].is_python, sum(t.time_s for t in item[1]))):
        usual_s = sum(test.time_s for test in reaching)
        done = run(build, command, [test.name for test in reaching], mutant, MIN_TIME_S + TIMES * usual_s)
        if done.failed:
            return f"{done.failed} of {Path(command[0]).name}" if done.failed == "time-out" else done.failed
    return ""
