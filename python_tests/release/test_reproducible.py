"""Two releases of a commit are the same bytes, and each download of a release has its pinned hash."""

import os
import re
import shutil
import subprocess
import tarfile
import tomllib
import zipfile
from importlib.metadata import distributions
from pathlib import Path

import pytest

from checkout import TOP

pytest.importorskip("cyclonedx", reason="cyclonedx-python-lib is not installed")

import c_packages
import fmu_archives
import sbom
import source_date
import wheel as release_wheel

DATE = (2023, 11, 14, 22, 13, 20)


@pytest.fixture
def open_umask():
    """Sets the umask by a call; the old one comes back."""
    old = os.umask(0o022)
    os.umask(old)
    yield os.umask
    os.umask(old)


def test_a_date_is_asked_for(monkeypatch):
    assert source_date.of_zip() == DATE
    for wrong in ("", "yesterday", "12", "-5"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", wrong)
        with pytest.raises(SystemExit, match="git log -1"):
            source_date.seconds()


def test_an_archive_made_twice_is_the_same_bytes(tmp_path):
    for name, order in (("one.fmu", (0, 1)), ("two.fmu", (1, 0))):
        files = [("./modelDescription.xml", "<x/>"), ("resources/a.csv", "1,2")]
        with zipfile.ZipFile(tmp_path / "host.fmu", "w") as host:
            for k in order:
                host.writestr(zipfile.ZipInfo(files[k][0], (2000 + k, 1, 1, 0, 0, 0)), files[k][1])
        fmu_archives.write_archive(tmp_path / "host.fmu", {"binaries/win64/M.dll": b"dll"}, tmp_path / name)
    assert (tmp_path / "one.fmu").read_bytes() == (tmp_path / "two.fmu").read_bytes()
    with zipfile.ZipFile(tmp_path / "one.fmu") as archive:
        assert {i.date_time for i in archive.infolist()} == {DATE}


@pytest.mark.skipif(not all(map(shutil.which, ("cmake", "cpack", "ninja"))), reason="cmake or ninja is not installed")
def test_packages_made_twice_are_the_same_bytes(tmp_path):
    made = []
    for k, names in enumerate((("a.h", "b.h", "c.h"), ("c.h", "b.h", "a.h"))):
        source = tmp_path / f"place{k}"
        (source / "include" / "hnav").mkdir(parents=True)
        for name in names:
            (source / "include" / "hnav" / name).write_text(name)
            os.utime(source / "include" / "hnav" / name, (1e9 + k, 1e9 + k))
        (source / "LICENSE").write_text("free")
        (source / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.22)\nproject(hnav VERSION 1.2.3 LANGUAGES NONE DESCRIPTION d)\nset(HNAV_GLIBC 2.17)\n"
            f"install(DIRECTORY include DESTINATION .)\ninclude({TOP}/cmake/package.cmake)\n"
        )
        subprocess.run(["cmake", "-G", "Ninja", "-S", source, "-B", source / "build"], check=True, capture_output=True)
        dist = source / "dist"
        dist.mkdir()
        c_packages.main(source / "build", dist)
        made.append({p.name: p.read_bytes() for p in dist.iterdir()})
    assert len(made[0]) == 2 and made[0] == made[1]
    with tarfile.open(next(dist.glob("*.tar.gz"))) as archive:
        found = archive.getmembers()
    assert [m.name for m in found] == sorted(m.name for m in found) and {m.name.rsplit("/", 1)[1] for m in found} >= {
        "a.h",
        "b.h",
        "c.h",
    }
    assert {(m.mtime, m.uid, m.gid, m.uname, m.gname) for m in found} == {(1_700_000_000, 0, 0, "root", "root")}


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler is installed")
def test_a_wheel_made_twice_is_the_same_bytes(tmp_path, monkeypatch, open_umask):
    lacking = {"setuptools", "wheel"} - {d.name for d in distributions()}
    if lacking:
        pytest.skip(f"not installed: {', '.join(sorted(lacking))}")
    parts = {n: sbom.Part(n, "1", "MIT", "0" * 64, "pkg:generic/x@1", "https://example.org", "said") for n in sbom.WHEEL}
    monkeypatch.setattr(sbom, "read_parts", lambda build: parts)
    made = []
    for k, umask in enumerate((0o022, 0o077)):
        open_umask(umask)
        build, dist = tmp_path / f"build{k}", tmp_path / f"dist{k}"
        for folder in (build / "c_src", dist / "fmi2", dist / "fmi3"):
            folder.mkdir(parents=True)
        (build / "c_src" / "libhnav.so").write_bytes(b"library")
        (dist / "fmi3" / "M.fmu").write_bytes(b"fmu")
        release_wheel.main(build, dist, {"x86_64-linux": build / "c_src"})
        made.append(next(dist.glob("hnav-*.whl")).read_bytes())
    assert made[0] == made[1]
    with zipfile.ZipFile(next(dist.glob("hnav-*.whl"))) as archive:
        assert {i.date_time for i in archive.infolist()} == {DATE}
        assert sum(n.endswith(".dist-info/sboms/hnav.cdx.json") for n in archive.namelist()) == 1


def pins() -> dict[str, list[str]]:
    """The lines behind each package of release/requirements.txt, by name and version."""
    text = (TOP / "release" / "requirements.txt").read_text()
    found = re.findall(r"^(\S.*?) \\\n((?: .*\n)+)", text, re.M)
    assert len(found) == len([line for line in text.splitlines() if line and line[0] not in " #"])
    return {name: re.findall(r"--hash=(\S+)", lines) for name, lines in found}


def test_every_package_of_a_release_has_one_version_and_its_hashes():
    for name, hashes in pins().items():
        assert re.fullmatch(r"[a-z0-9-]+==[^\s;]+( ; .+)?", name), name
        assert hashes and all(re.fullmatch(r"sha256:[0-9a-f]{64}", h) for h in hashes), name


def test_the_pins_are_those_of_the_project():
    requirements = pytest.importorskip("packaging.requirements", reason="packaging is not installed")
    project = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]
    pinned = [requirements.Requirement(name) for name in pins()]
    for wanted in map(requirements.Requirement, project["dependencies"] + project["optional-dependencies"]["release"]):
        versions = [next(iter(p.specifier)).version for p in pinned if p.name.lower() == wanted.name.lower()]
        assert versions and all(v in wanted.specifier for v in versions), f"{wanted}: compile release/requirements.txt again"


def configured(tmp_path: Path, *options: str, archive: bytes) -> str:
    """Output of CMake for a project that includes cmake/sundials.cmake, where apt brings this archive."""
    (tmp_path / "c_src" / "hybrid").mkdir(parents=True)
    (tmp_path / "c_src" / "hybrid" / "sundials_memory.h").write_text("")
    (tmp_path / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.22)\nproject(p LANGUAGES NONE)\ninclude({TOP}/cmake/sundials.cmake)\n"
    )
    (tmp_path / "archive").write_bytes(archive)
    (tmp_path / "bin").mkdir()
    apt = tmp_path / "bin" / "apt-get"
    apt.write_text(
        f'#!/bin/sh\ncase "$*" in *"source --download-only"*) cp "{tmp_path}/archive" sundials_9.orig.tar.gz ;; esac\n'
    )
    apt.chmod(0o755)
    command = ["cmake", "-G", "Ninja", "-S", tmp_path, "-B", tmp_path / "build", *options]
    environment = os.environ | {"PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode != 0
    return " ".join((done.stdout + done.stderr).split())


@pytest.mark.skipif(not all(map(shutil.which, ("cmake", "ninja"))), reason="cmake or ninja is not installed")
def test_a_changed_archive_of_sundials_is_refused(tmp_path):
    upstream = tmp_path / "upstream.tar.gz"
    upstream.write_bytes(b"changed")
    url = f"-DHNAV_SUNDIALS_URL=file://{upstream}"
    said = configured(tmp_path, url, "-DHNAV_PINNED=ON", archive=b"also changed")
    assert re.search(
        r"sundials_9\.orig\.tar\.gz has SHA-256 [0-9a-f]{64}, which is not pinned in cmake/sundials\.cmake, and is not taken",
        said,
    )
    assert re.search(r"upstream\.tar\.gz has SHA-256 [0-9a-f]{64}, expected [0-9a-f]{64}", said)
