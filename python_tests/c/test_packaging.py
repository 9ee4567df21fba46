"""The installed library as others use it: find_package, pkg-config, shared and static."""

import os
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from checkout import BUILD, TOP

EXPECTED = "roll 20.0  pitch 5.0  heading 30.0 deg"


def run(*command, **options) -> str:
    done = subprocess.run(command, capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory) -> Path:
    if not (BUILD / "CMakeCache.txt").is_file():
        pytest.skip(f"no build in {BUILD}")
    folder = tmp_path_factory.mktemp("installed here")
    run("cmake", "--install", str(BUILD), "--prefix", str(folder))
    return folder


def test_find_package_builds_with_the_shared_and_the_static_library(prefix, tmp_path):
    source = TOP / "c_src" / "examples" / "consumer"
    run("cmake", "-S", str(source), "-B", str(tmp_path), f"-DCMAKE_PREFIX_PATH={prefix}")
    run("cmake", "--build", str(tmp_path))
    for program in ("with_shared", "with_static"):
        assert EXPECTED in run(str(tmp_path / program))


needs_pkg_config = pytest.mark.skipif(shutil.which("pkg-config") is None, reason="pkg-config is not installed")


def by_pkg_config(prefix: Path, program: Path, *more: str, static: bool = False) -> None:
    """The example in C, compiled and linked by a C compiler alone."""
    folder = next(prefix.rglob("hnav.pc")).parent
    # The prefix written at configuration time gives way to where it was installed.
    environment = os.environ | {"PKG_CONFIG_PATH": str(folder)}
    variable = f"--define-variable=prefix={str(prefix).replace(' ', chr(92) + ' ')}"
    flags = run("pkg-config", variable, *(["--static"] if static else []), "--cflags", "--libs", "hnav", env=environment)
    run("cc", str(TOP / "c_src" / "examples" / "minimal.c"), "-o", str(program), *more, *shlex.split(flags))


@needs_pkg_config
def test_pkg_config_builds_with_a_c_compiler(prefix, tmp_path):
    program = tmp_path / "minimal"
    by_pkg_config(prefix, program)
    libraries = next(prefix.rglob("libhnav.so")).parent
    assert EXPECTED in run(str(program), env=os.environ | {"LD_LIBRARY_PATH": str(libraries)})


@needs_pkg_config
def test_a_c_compiler_links_everything_statically(prefix, tmp_path):
    program = tmp_path / "minimal"
    by_pkg_config(prefix, program, "-static", static=True)
    assert "NEEDED" not in run("readelf", "-d", str(program))
    assert EXPECTED in run(str(program))


def test_the_shared_library_carries_the_version_of_its_interface_and_exports_hnav_alone():
    library = BUILD / "c_src" / "libhnav.so"
    assert "[libhnav.so.0.2]" in run("readelf", "-d", str(library))
    exported = [line.split()[-1] for line in run("nm", "-D", "--defined-only", str(library)).splitlines()]
    assert exported and all(name.startswith("hnav_") for name in exported), exported
