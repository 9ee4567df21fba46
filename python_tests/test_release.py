"""What is released: the rules for binaries, the archives of all platforms, the wheel. dist/ comes from ./run release."""

import os
import sys
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("elftools", reason="pyelftools is not installed")
pytest.importorskip("pefile", reason="pefile is not installed")

TOP = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "release"))

import binaries  # noqa: E402
import fmu_archives  # noqa: E402
import trajectories  # noqa: E402
from platforms import PLATFORMS  # noqa: E402

BUILD = Path(os.environ.get("HNAV_BUILD", TOP / "build"))
DIST = Path(os.environ.get("HNAV_DIST", TOP / "dist"))


@pytest.fixture
def dist() -> Path:
    if not list(DIST.glob("fmi3/*.fmu")):
        pytest.skip(f"no FMU in {DIST}: ./run release makes them")
    return DIST


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
    for name in ("one.fmu", "two.fmu"):
        fmu_archives.write_archive(tmp_path / "host.fmu", {"binaries/win64/M.dll": b"dll"}, tmp_path / name)
    with zipfile.ZipFile(tmp_path / "one.fmu") as archive:
        assert archive.namelist() == ["binaries/win64/M.dll", "modelDescription.xml"]
    assert (tmp_path / "one.fmu").read_bytes() == (tmp_path / "two.fmu").read_bytes()


def test_a_platform_that_was_not_built_ends_with_the_name_of_the_missing_file(tmp_path):
    with pytest.raises(SystemExit, match="M.dll is not built"):
        fmu_archives.collect("M", 3, {"x86_64-windows": tmp_path})


@pytest.mark.parametrize("version", [2, 3])
def test_every_released_fmu_holds_a_binary_for_each_platform(dist, version):
    expected = {p.folder(version) for p in PLATFORMS if p.folder(version)}
    for fmu in dist.glob(f"fmi{version}/*.fmu"):
        with zipfile.ZipFile(fmu) as archive:
            assert {n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")} == expected, fmu.name


def test_released_binaries_need_no_more_than_glibc_2_17_and_system_dlls(dist):
    for name, (content, prefix) in binaries.binaries(dist).items():
        assert binaries.faults(binaries.needs(content), prefix) == [], name


def test_the_wheel_holds_library_fmus_and_models_and_names_its_platform(dist):
    wheels = list(dist.glob("hnav-*.whl"))
    if not wheels:
        pytest.skip(f"no wheel in {dist}")
    assert len(wheels) == 1 and wheels[0].name.endswith("-py3-none-manylinux_2_17_x86_64.whl")
    with zipfile.ZipFile(wheels[0]) as archive:
        names = set(archive.namelist())
    assert {"hnav/libhnav.so", "hnav/fmus/fmi2/Aligner.fmu", "hnav/fmus/fmi3/Hrekf.fmu"} <= names
    assert any(n.startswith("hnav/models/aircraft/") for n in names)
