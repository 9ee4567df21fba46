"""Archives that hold their sources: compiled by fmpy, gcc and clang they give the numbers of the binary inside."""

import shutil
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import fmpy
import fmpy.build
import numpy as np
import pytest

from fmi.test_fmu_arrays import get_reals, real_outputs, sample, set_reals
from hnav.fmi.fmus import Fmu, fmu_path, item_value

WITH_SOURCES = (
    "Ahrs", "AhrsArrays", "Hrekf", "Ins", "InsErrorFilterLateral", "InsErrorFilterLongitudinal", "AircraftInsLateral",
    "AircraftInsLongitudinal", "Turntable", "ImuMagSensor", "Pendulum", "Vehicle", "Gnss", "Baro", "Wheel",
)  # fmt: skip
VERSIONS = (2, 3)
HEADERS = Path(fmpy.__file__).parent / "c-code"


def source_files(name: str, version: int) -> list[str]:
    """As importers find them: FMI 2 in the description, FMI 3 in a file of its own."""
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        if version == 3:
            return [e.get("name") for e in ET.fromstring(archive.read("sources/buildDescription.xml")).iter("SourceFile")]
        interfaces = ET.fromstring(archive.read("modelDescription.xml"))
        lists = [[e.get("name") for e in i.iter("File")] for i in interfaces if i.tag in ("CoSimulation", "ModelExchange")]
    assert len(lists) in (1, 2) and lists[0] == lists[-1]
    return lists[0]


def signal(name: str) -> np.ndarray | None:
    """The example input of an archive."""
    with zipfile.ZipFile(fmu_path(name, 3)) as archive:
        if "resources/example_input.csv" not in archive.namelist():
            return None
        return np.genfromtxt(archive.open("resources/example_input.csv"), delimiter=",", names=True, deletechars="")


def run(path: Path, name: str) -> np.ndarray:
    """All outputs that are numbers, by fmpy; filters go by the closed form, which binary and sources both have."""
    if name.endswith("Arrays"):
        return run_arrays(path)
    description = fmpy.read_model_description(str(path))
    numbers = [v.name for v in description.modelVariables if v.causality == "output" and v.type in ("Real", "Float64")]
    closed = {v.name: item_value(v, "closed_form") for v in description.modelVariables if v.name == "solver.solver"}
    seen = fmpy.simulate_fmu(
        str(path),
        stop_time=8,
        output_interval=0.02,
        input=signal(name),
        start_values=closed,
        output=numbers,
        fmi_type="CoSimulation",
    )
    assert len(numbers) > 0
    return np.concatenate([np.ravel(seen[column]) for column in seen.dtype.names])


def run_arrays(path: Path) -> np.ndarray:
    """fmpy gives arrays no signal."""
    with Fmu(path) as fmu:
        fmu.set("solver.solver", "closed_form")
        fmu.initialise()
        for k in range(300):
            set_reals(fmu, sample(k))
            fmu.do_step(0.01 * k, 0.01)
        return np.array(get_reals(fmu, real_outputs(fmu)))


def compile_by_fmpy(folder: Path, version: int, name: str) -> None:
    fmpy.build.build_platform_binary(folder, cmake_options={"CMAKE_CXX_FLAGS_RELEASE:STRING": "-O1 -DNDEBUG"})


def compile_by(compiler: str):
    def compile_here(folder: Path, version: int, name: str) -> None:
        target = folder / "binaries" / ("linux64" if version == 2 else "x86_64-linux") / f"{name}.so"
        files = [folder / "sources" / file for file in source_files(name, version)]
        command = [compiler, "-std=c++17", "-O1", "-DNDEBUG", "-fPIC", "-shared", "-I", folder / "sources", "-I", HEADERS]
        subprocess.run([*command, *files, "-o", target, "-Wl,-z,defs", "-lm"], check=True)

    return compile_here


@pytest.mark.parametrize(
    "name, version", [(name, version) for name in WITH_SOURCES for version in VERSIONS if (name, version) != ("AhrsArrays", 2)]
)
def test_the_list_of_sources_is_short_and_all_of_them_are_inside(name, version):
    files = source_files(name, version)
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        inside = {n.removeprefix("./") for n in archive.namelist()}
        together = archive.read("sources/fmu.cpp").decode()
    assert len(files) <= 12 and {f"sources/{file}" for file in files} <= inside
    included = [line.split('"')[1] for line in together.splitlines() if line.startswith("#include")]
    assert f"adapter/fmi{version}.cpp" in included and {f"sources/{file}" for file in included} <= inside
    assert "documentation/licenses/Eigen.txt" in inside or not any("licenses/Eigen" in n for n in inside)
    assert not any("sundials" in n.lower() and n.endswith((".c", ".cpp")) and "without" not in n for n in inside)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, version, compiler",
    [
        ("Ahrs", 3, "fmpy"),
        ("Hrekf", 2, "fmpy"),
        ("Ahrs", 2, "g++"),
        ("Hrekf", 3, "g++"),
        ("Ahrs", 3, "clang++"),
        ("Hrekf", 2, "clang++"),
        *((name, 3, "g++") for name in WITH_SOURCES if name not in ("Ahrs", "Hrekf") and "Longitudinal" not in name),
    ],
)
def test_compiled_from_its_sources_it_gives_the_numbers_of_the_binary(name, version, compiler, tmp_path):
    if compiler != "fmpy" and not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")
    folder = tmp_path / name
    fmpy.extract(str(fmu_path(name, version)), str(folder))
    shutil.rmtree(folder / "binaries")
    (folder / "binaries" / ("linux64" if version == 2 else "x86_64-linux")).mkdir(parents=True)
    (compile_by_fmpy if compiler == "fmpy" else compile_by(compiler))(folder, version, name)
    compiled = tmp_path / f"{name}.fmu"
    with zipfile.ZipFile(compiled, "w") as archive:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            archive.write(file, file.relative_to(folder).as_posix())
    np.testing.assert_allclose(run(compiled, name), run(fmu_path(name, version), name), rtol=1e-12, atol=1e-12)
