"""Build requirements that pip fetches for hnav from source, and the content of a source archive."""

import importlib.util
import subprocess
import sys
import tarfile

import pytest

from checkout import TOP

pytest.importorskip("scikit_build_core", reason="scikit-build-core is not installed")


@pytest.fixture
def backend():
    path = TOP / "release" / "from_source" / "backend.py"
    spec = importlib.util.spec_from_file_location("backend", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def names(requirements: list[str]) -> set[str]:
    return {r.split(">")[0] for r in requirements}


def test_a_machine_without_compiler_and_eigen_is_given_both(backend, monkeypatch):
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setattr(backend, "COMPILERS", ("no-such-compiler",))
    monkeypatch.setattr(backend, "has_eigen", lambda: False)
    assert {"cffi", "fmpy", "ziglang", "cmeel-eigen"} <= names(backend.get_requires_for_build_wheel())
    monkeypatch.setenv("CXX", "c++")
    monkeypatch.setattr(backend, "has_eigen", lambda: True)
    wanted = names(backend.get_requires_for_build_wheel())
    assert {"cffi", "fmpy"} <= wanted and not {"ziglang", "cmeel-eigen"} & wanted


def test_what_is_built_already_needs_nothing_more(backend):
    assert backend.get_requires_for_build_wheel({"wheel.cmake": "false"}) == []


def test_a_machine_that_zig_is_not_set_up_for_asks_for_a_compiler(backend, monkeypatch):
    monkeypatch.setattr(backend.platform, "machine", lambda: "riscv64")
    with pytest.raises(SystemExit, match="riscv64 needs a C\\+\\+17 compiler"):
        backend.zig_toolchain()


def test_a_source_archive_holds_what_a_build_reads(tmp_path):
    code = f"import sys; sys.path.insert(0, 'release/from_source'); import backend; backend.build_sdist({str(tmp_path)!r})"
    done = subprocess.run([sys.executable, "-c", code], cwd=TOP, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with tarfile.open(next(tmp_path.glob("hnav-*.tar.gz"))) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    listed = subprocess.run(
        ["git", "ls-files", "CMakeLists.txt", "cmake", "c_src", "fmu", "models", "python/hnav", "release/from_source", "LICENSE"],
        cwd=TOP, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert set(listed.stdout.split()) <= held
    assert not {name for name in held if name.startswith((".venv/", "build", ".cache/", ".git/"))}
