"""The release: the rules for binaries, the archives of all platforms, the wheel. dist/ comes from ./run release."""

import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from checkout import BUILD, TOP

pytest.importorskip("elftools", reason="pyelftools is not installed")
pytest.importorskip("pefile", reason="pefile is not installed")
pytest.importorskip("lief", reason="lief is not installed")
pytest.importorskip("cyclonedx", reason="cyclonedx-python-lib is not installed")

import binaries
import fmu_archives
import installed
import packages
import trajectories
import wheel as release_wheel
from platforms import PLATFORMS, Platform

import hnav


def test_every_fmu_of_the_build_needs_only_the_c_library_and_exports_fmi_alone():
    if not list(BUILD.glob("fmus/fmi3/*.fmu")):
        pytest.skip(f"no FMU in {BUILD}")
    built = binaries.binaries(BUILD / "fmus")
    for name, (content, prefix) in built.items():
        # The glibc of a build for this machine alone is this machine's.
        assert [f for f in binaries.faults(binaries.needs(content), prefix) if "glibc" not in f] == [], name
    assert len(built) == len(list(BUILD.glob("fmus/fmi?/*.fmu")))


def test_a_foreign_export_a_foreign_library_and_a_new_glibc_are_named():
    what = binaries.Needs(("fmi3GetVersion", "helper"), ("libc.so.6", "libstdc++.so.6"), (2, 34))
    assert binaries.faults(what, "fmi3") == ["exports helper", "needs libstdc++.so.6", "needs glibc 2.34"]
    assert binaries.faults(binaries.Needs((), (), None), "fmi3") == ["exports nothing"]
    assert binaries.faults(binaries.Needs(("fmi3Reset",), (), paths=True), "fmi3") == [f"holds the path {TOP}"]


def test_a_mac_takes_only_what_is_signed_and_not_newer_than_itself():
    good = binaries.Needs(("fmi3Reset",), ("/usr/lib/libSystem.B.dylib",), macos=(11, 0, 0), signed=True)
    assert binaries.faults(good, "fmi3") == []
    assert binaries.faults(replace(good, macos=(13, 1, 0), signed=False), "fmi3") == ["needs macOS 13.1.0", "is not signed"]
    assert binaries.faults(replace(good, libraries=("/usr/lib/libc++.1.dylib",)), "fmi3") == ["needs /usr/lib/libc++.1.dylib"]


def test_the_tolerance_of_trajectories_sees_a_value_a_shape_and_a_nan():
    a = trajectories.np.array([[1.0, 2000.0]])
    assert trajectories.difference(a, a) == 0
    assert trajectories.difference(a + [[0, 2e-5]], a) == pytest.approx(1e-8, rel=1e-3)
    assert trajectories.difference(a[:, :1], a) == trajectories.np.inf
    assert trajectories.difference(a * [[1, trajectories.np.nan]], a) == trajectories.np.inf


def test_an_archive_of_all_platforms_keeps_the_rest_and_drops_this_machines_binary(tmp_path):
    with zipfile.ZipFile(tmp_path / "host.fmu", "w") as host:
        host.writestr("./modelDescription.xml", "<x/>")
        host.writestr("binaries/linux64/M.so", "host")
    fmu_archives.write_archive(tmp_path / "host.fmu", {"binaries/win64/M.dll": b"dll"}, tmp_path / "all.fmu")
    with zipfile.ZipFile(tmp_path / "all.fmu") as archive:
        assert archive.namelist() == ["binaries/win64/M.dll", "modelDescription.xml"]


def test_the_plant_inside_an_observer_has_its_binaries_too(tmp_path):
    with zipfile.ZipFile(tmp_path / "observer.fmu", "w") as built:
        for name in ("binaries/linux64/O.so", "resources/plant/binaries/linux64/P.so", "resources/plant/observer.plan"):
            built.writestr(f"./{name}", name)
    assert fmu_archives.plants_of(tmp_path / "observer.fmu") == ["P"]
    with zipfile.ZipFile(tmp_path / "other.fmu", "w") as built:
        built.writestr("binaries/linux64/P.so", "")
    assert fmu_archives.plants_of(tmp_path / "other.fmu") == []


def test_a_platform_that_was_not_built_ends_with_the_name_of_the_missing_file(tmp_path):
    with pytest.raises(SystemExit, match="M.dll is not built"):
        fmu_archives.collect("M", 3, {"x86_64-windows": tmp_path})


def test_a_system_takes_the_released_fmus(tmp_path):
    with zipfile.ZipFile(tmp_path / "s.ssp", "w") as built:
        built.writestr("./SystemStructure.ssd", "<x/>")
        built.writestr("resources/M.fmu", "host")
    with pytest.raises(SystemExit, match="s.ssp holds resources/M.fmu, and there is no .*fmi2/M.fmu"):
        fmu_archives.fmus_of(tmp_path / "s.ssp", tmp_path)
    (tmp_path / "fmi2").mkdir()
    (tmp_path / "fmi2" / "M.fmu").write_bytes(b"released")
    fmus = fmu_archives.fmus_of(tmp_path / "s.ssp", tmp_path)
    fmu_archives.write_archive(tmp_path / "s.ssp", fmus, tmp_path / "new.ssp")
    with zipfile.ZipFile(tmp_path / "new.ssp") as archive:
        assert {n: archive.read(n) for n in archive.namelist()} == {
            "SystemStructure.ssd": b"<x/>",
            "resources/M.fmu": b"released",
        }


def test_an_emulator_that_is_not_here_is_named_with_its_package(tmp_path):
    absent = Platform("x", "x", "x", ".so", "x", "x", emulators=("no-such-emulator", "nor-this"), debian="some-package")
    assert absent.runner() is None
    assert absent.advice() == "no-such-emulator or nor-this is missing (Debian, Ubuntu: apt-get install some-package)"
    arguments = ("-L", str(tmp_path / "libraries"))
    half = replace(absent, emulators=(sys.executable,), emulator_arguments=arguments)
    assert half.runner() is None
    (tmp_path / "libraries").mkdir()
    assert half.runner() == [sys.executable, "-L", str(tmp_path / "libraries")]
    assert PLATFORMS[0].runner() == []
    mac = next(p for p in PLATFORMS if p.name == "aarch64-macos")
    assert mac.runner() is None
    assert "on such a machine only" in mac.advice()


@pytest.mark.parametrize("version", [2, 3])
def test_the_drive_of_every_fmu_moves_its_outputs_and_has_no_holes(version, tmp_path):
    if not list(BUILD.glob(f"fmus/fmi{version}/*.fmu")):
        pytest.skip(f"no FMU in {BUILD}")
    for fmu in [fmu for made_for, fmu in trajectories.comparable(BUILD / "fmus") if made_for == version]:
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(tmp_path / fmu.stem)
        plan = trajectories.read_plan(tmp_path / fmu.stem)
        outputs = trajectories.run_by_fmpy(plan, tmp_path / fmu.stem)
        assert len(plan.t_s) > 200 and plan.inputs.shape == (len(plan.t_s), sum(map(len, plan.input_references))), fmu
        assert outputs.shape == (len(plan.t_s) - 1, sum(map(len, plan.output_references))), fmu
        assert trajectories.np.isfinite(outputs).all(), fmu
        # A sensor of one number states its sigma and counts, which are constant.
        assert (outputs.std(axis=0) > 0).sum() >= (8 if outputs.shape[1] > 8 else 3), fmu


def test_an_output_of_another_type_is_named(tmp_path):
    (tmp_path / "modelDescription.xml").write_text(
        '<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="M"/><ModelVariables>'
        '<Float32 name="y" valueReference="1" causality="output"/></ModelVariables><ModelStructure/></fmiModelDescription>'
    )
    with pytest.raises(SystemExit, match="M: y is of type Float32"):
        trajectories.read_plan(tmp_path)


def test_one_version_everywhere():
    wanted = packages.version()
    assert re.fullmatch(r"\d+\.\d+\.\d+", wanted)
    assert hnav.__version__ == wanted
    assert tomllib.loads((TOP / "pyproject.toml").read_text())["project"]["version"] == wanted


@pytest.mark.parametrize("check", [binaries.main, packages.main, lambda dist: installed.main(dist, {})])
def test_a_check_of_an_empty_folder_says_what_is_missing(check, tmp_path):
    with pytest.raises(SystemExit, match=str(tmp_path)):
        check(tmp_path)


def test_a_library_that_is_not_built_ends_with_its_name(tmp_path):
    with pytest.raises(SystemExit, match="libhnav.dll is not built"):
        release_wheel.make(PLATFORMS[1], tmp_path / PLATFORMS[1].library, tmp_path, {})


def test_a_library_that_answers_wrongly_is_reported(tmp_path):
    with zipfile.ZipFile(tmp_path / "hnav.whl", "w") as wheel:
        wheel.writestr("hnav/libhnav.so", "no library")
    with pytest.raises(SystemExit, match="hnav.whl: true says nothing"):
        installed.library_answers(PLATFORMS[0], tmp_path / "hnav.whl", Path(shutil.which("true")))


def test_a_wheel_that_does_not_install_ends_with_what_pip_said(tmp_path):
    (tmp_path / "hnav-0-py3-none-manylinux_2_17_x86_64.whl").write_bytes(b"no archive")
    with pytest.raises(SystemExit, match="installed: -m pip install .*(?s:.*)(?i:error)"):
        installed.main(tmp_path, {})


@pytest.mark.parametrize("version", [2, 3])
def test_every_released_fmu_holds_a_binary_for_each_platform(dist, version):
    expected = {p.folder(version) for p in PLATFORMS if p.folder(version)}
    for fmu in dist.glob(f"fmi{version}/*.fmu"):
        with zipfile.ZipFile(fmu) as archive:
            assert {n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")} == expected, fmu.name


def test_released_binaries_need_no_more_than_glibc_2_17_and_system_dlls(dist):
    for name, (content, prefix) in binaries.binaries(dist).items():
        assert binaries.faults(binaries.needs(content), prefix) == [], name


@pytest.mark.parametrize("platform", PLATFORMS, ids=[p.name for p in PLATFORMS])
def test_each_wheel_holds_library_fmus_and_models_and_names_its_platform(dist, platform):
    wheel = installed.wheel_of(platform, dist)
    assert wheel.name == f"hnav-{packages.version()}-py3-none-{platform.wheel}.whl"
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert {f"hnav/fmus/{fmu.relative_to(dist)}" for fmu in dist.glob("fmi?/*.fmu")} | {f"hnav/{platform.library}"} <= names
    models = [p.relative_to(TOP) for p in (TOP / "models").rglob("*") if p.is_file()]
    assert {f"hnav/{p}" for p in models} <= names


def test_the_names_in_dist_carry_the_version(dist):
    version = packages.version()
    assert {p.name for p in dist.iterdir()} == {
        "fmi2", "fmi3", "ssp", "SHA256SUMS", f"hnav-{version}.cdx.json", f"libhnav-dev_{version}_amd64.deb",
        f"libhnav-dev-{version}-Linux.tar.gz", *(f"hnav-{version}-py3-none-{p.wheel}.whl" for p in PLATFORMS),
    }  # fmt: skip


@pytest.mark.skipif(not (shutil.which("cmake") and shutil.which("pkg-config")), reason="cmake or pkg-config is not installed")
def test_both_packages_serve_another_project(dist, capsys):
    packages.main(dist)
    assert capsys.readouterr().out.count("programs that run") == 1 + bool(shutil.which("dpkg-deb"))


def test_the_installed_wheel_filters_and_simulates(dist):
    # By the Python that has made the release: in this one the checkout's hnav is installed, and comes first.
    python = TOP / ".cache" / "release-python" / "bin" / "python"
    if not python.exists():
        pytest.skip("no Python of a release: ./run release makes it")
    done = subprocess.run([python, TOP / "release" / "installed.py", dist], capture_output=True, text=True)
    assert "equal last rows; hnav simulate turntable, aircraft" in done.stdout, done.stderr
