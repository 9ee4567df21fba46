"""Where the library is found, which modules are loaded at import, and calls from several threads."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from test_binding import STRUCTS

import hnav
from hnav import Filter, HnavRuntimeError
from hnav.native import library as native


def said(code: str, *options: str, **environment: str) -> str:
    """The output of a fresh interpreter."""
    done = subprocess.run([sys.executable, *options, "-c", code], capture_output=True, text=True, env=os.environ | environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_versions_agree():
    assert native.version() == hnav.__version__


def test_importing_hnav_loads_no_large_package():
    loaded = said("import sys, hnav; print(*sys.modules)").split()
    assert "hnav.errors" in loaded
    assert not {"numpy", "pandas", "scipy", "fmpy", "cffi", "typer", "hnav.native.library"} & set(loaded)


def test_importing_hnav_takes_little_time():
    """Thread CPU of a fresh interpreter, median of 10; the machine may be busy, so the test leaves room."""
    code = "import time; begin = time.thread_time(); import hnav; print(time.thread_time() - begin)"
    assert np.median([float(said(code)) for _ in range(10)]) < 0.15


def test_a_name_of_the_package_is_loaded_when_it_is_asked_for():
    assert said("import sys, hnav; hnav.Filter; print('numpy' in sys.modules, 'pandas' in sys.modules)") == "True False"
    assert set(hnav.__all__) <= set(dir(hnav))
    for name in hnav.__all__:
        assert getattr(hnav, name) is not None
    with pytest.raises(AttributeError, match="nothing_of_the_kind"):
        _ = hnav.nothing_of_the_kind


def test_the_library_is_the_one_that_the_environment_names(monkeypatch, tmp_path):
    monkeypatch.setenv("HNAV_LIBRARY", str(tmp_path / "other.so"))
    assert native.library_path() == tmp_path / "other.so"


def test_the_packaged_library_comes_before_the_build(monkeypatch, tmp_path):
    monkeypatch.delenv("HNAV_LIBRARY", raising=False)
    package, built = tmp_path / "package", tmp_path / "checkout" / "build" / "c_src" / "libhnav.so"
    monkeypatch.setattr(native, "PACKAGE", package)
    monkeypatch.setattr(native, "CHECKOUT", tmp_path / "checkout")
    with pytest.raises(HnavRuntimeError, match="./run build makes it, or set HNAV_LIBRARY"):
        native.library_path()
    built.parent.mkdir(parents=True)
    built.touch()
    assert native.library_path() == built
    package.mkdir()
    (package / "libhnav.so").touch()
    assert native.library_path() == package / "libhnav.so"


@pytest.mark.parametrize("content", [None, b"no library"])
def test_a_library_that_cannot_be_loaded_is_named(tmp_path, content):
    path = tmp_path / "broken.so"
    if content is not None:
        path.write_bytes(content)
    code = "import hnav\ntry: hnav.Filter('ahrs')\nexcept hnav.HnavRuntimeError as error: print(error)"
    assert f"{path} cannot be loaded" in said(code, HNAV_LIBRARY=str(path))


def test_a_checkout_without_the_binding_says_how_to_make_it(tmp_path):
    """As a checkout is before its first build."""
    source = Path(hnav.__file__).parent
    (tmp_path / "hnav" / "native").mkdir(parents=True)
    for name in ("__init__.py", "errors.py", "places.py", "native/__init__.py", "native/library.py"):
        (tmp_path / "hnav" / name).write_text((source / name).read_text())
    code = "try: import hnav.native.library\nexcept ImportError as error: print(error)"
    # Without site, which would find the installed package first.
    assert "./run build makes it" in said(code, "-S", PYTHONPATH=str(tmp_path))


def test_structs_that_begin_with_their_size_get_it():
    for name in STRUCTS:
        struct = native.new(name)
        if hasattr(struct, "size"):
            assert struct.size == native.ffi.sizeof(name), name
    assert native.new("hnav_run_input").t_s == native.ffi.NULL


# --------------------------------------------------------------------------------------------- threads


def samples(seconds: float):
    n = int(200 * seconds)
    t = np.arange(n) * 0.005
    rate = np.stack([np.sin(t), np.cos(2 * t), np.sin(3 * t)], axis=1)
    return t, rate, np.tile([0, 0, -9.81], (n, 1)), np.tile([2e-5, 0, 4e-5], (n, 1))


def test_filters_in_parallel_threads_give_the_bits_of_one_after_the_other():
    arrays = samples(20)
    expected, found = Filter("ahrs").run(*arrays), [None] * 4

    def work(i: int) -> None:
        found[i] = Filter("ahrs").run(*arrays)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for run in found:
        assert np.array_equal(run.q_nb, expected.q_nb, equal_nan=True)
        assert np.array_equal(run.sigma_rad, expected.sigma_rad, equal_nan=True)


def test_a_call_of_the_library_lets_other_threads_go_on():
    """One long call in a thread; meanwhile this one counts on, which it could not without the interpreter's lock."""
    arrays, running = samples(600), threading.Event()

    def work() -> None:
        running.set()
        Filter("hrekf").run(*arrays)

    thread = threading.Thread(target=work)
    thread.start()
    running.wait()
    turns = 0
    while thread.is_alive():
        time.sleep(0.001)
        turns += 1
    thread.join()
    assert turns > 20
