"""Archives that hold their sources: compiled by fmpy, gcc and clang they give the numbers of the binary inside."""

import math
import shutil
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import fmpy
import fmpy.build
import pytest

from hnav.fmi.fmus import Fmu, fmu_path

FILTERS = ("Ahrs", "Hrekf", "Ins")
VERSIONS = (2, 3)
HEADERS = Path(fmpy.__file__).parent / "c-code"


def source_files(name: str, version: int) -> list[str]:
    """As importers find them: FMI 2 in the description, FMI 3 in a file of its own."""
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        if version == 3:
            return [e.get("name") for e in ET.fromstring(archive.read("sources/buildDescription.xml")).iter("SourceFile")]
        interfaces = ET.fromstring(archive.read("modelDescription.xml"))
        lists = [[e.get("name") for e in i.iter("File")] for i in interfaces if i.tag in ("CoSimulation", "ModelExchange")]
    assert len(lists) == 2 and lists[0] == lists[1]
    return lists[0]


def run(fmu: Fmu) -> list[float]:
    """All real outputs after three seconds (of navigation eight) of a body that turns, by the closed form, which both have."""
    fmu.set("solver.solver", "closed_form")
    fmu.initialise()
    for k in range(800 if "gnss.valid" in fmu.variables else 300):
        t = 0.01 * k
        values = {
            "gyro.rate": (0.1 * math.sin(t), 0.2, -0.1 * math.cos(3 * t)), "accel.force": (0.3 * math.sin(t), -0.2, -9.8),
            "mag.field": (2e-5, 1e-6 * math.sin(t), 4.5e-5), "gnssvel.velocity": (0.1 * t, 0.1, 0),
        }  # fmt: skip
        for name in ("gnss.valid", "gnssvel.valid"):
            if name in fmu.variables:
                fmu.set(name, True)
        for name, vector in values.items():
            if f"{name}[1]" not in fmu.variables:
                continue
            for i, value in enumerate(vector, start=1):
                fmu.set(f"{name}[{i}]", value)
        fmu.do_step(t, 0.01)
    return [fmu.get(v.name) for v in fmu.variables.values() if v.causality == "output" and v.type in ("Real", "Float64")]


def compile_by_fmpy(folder: Path, version: int, name: str) -> None:
    fmpy.build.build_platform_binary(folder, cmake_options={"CMAKE_CXX_FLAGS_RELEASE:STRING": "-O1 -DNDEBUG"})


def compile_by(compiler: str):
    def compile_here(folder: Path, version: int, name: str) -> None:
        target = folder / "binaries" / ("linux64" if version == 2 else "x86_64-linux") / f"{name}.so"
        files = [folder / "sources" / file for file in source_files(name, version)]
        command = [compiler, "-std=c++17", "-O1", "-DNDEBUG", "-fPIC", "-shared", "-I", folder / "sources", "-I", HEADERS]
        subprocess.run([*command, *files, "-o", target, "-Wl,-z,defs", "-lm"], check=True)

    return compile_here


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("version", VERSIONS)
def test_the_list_of_sources_is_short_and_all_of_them_are_inside(name, version):
    files = source_files(name, version)
    with zipfile.ZipFile(fmu_path(name, version)) as archive:
        inside = {n.removeprefix("./") for n in archive.namelist()}
        together = archive.read("sources/fmu.cpp").decode()
    assert len(files) <= 10 and {f"sources/{file}" for file in files} <= inside
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
        ("Ins", 3, "g++"),
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
    with Fmu(compiled) as ours, Fmu(fmu_path(name, version)) as theirs:
        assert run(ours) == pytest.approx(run(theirs), rel=1e-12, abs=1e-12)
