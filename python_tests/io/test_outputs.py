"""Files out: whole or as before, whatever happens; inputs are never overwritten."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from command_line import hnav
from hnav.errors import HnavError
from hnav.io import outputs
from hnav.io.outputs import OutputError, refuse_overwriting, write_files
from small_files import no_longer_than

OLD, NEW = b"old", b"new" * 1000


@pytest.fixture
def target(tmp_path) -> Path:
    path = tmp_path / "out.bin"
    path.write_bytes(OLD)
    return path


def test_a_file_is_replaced_with_its_rights_and_nothing_is_left_beside_it(target):
    target.chmod(0o640)
    write_files({target: NEW})
    assert target.read_bytes() == NEW
    assert target.stat().st_mode & 0o777 == 0o640
    assert list(target.parent.iterdir()) == [target]


def test_a_link_stays_a_link(target, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(target)
    write_files({link: NEW})
    assert link.is_symlink() and target.read_bytes() == NEW


def test_folders_are_made_when_asked_for(tmp_path):
    with pytest.raises(OutputError, match=r"cannot write .*/new/x: no such file or directory"):
        write_files({tmp_path / "new" / "x": NEW})
    write_files({tmp_path / "new" / "x": "ä"}, make_folders=True)
    assert (tmp_path / "new" / "x").read_bytes() == "ä".encode()


def test_a_file_that_does_not_fit_leaves_the_old_one_and_one_line(target):
    with no_longer_than(1000), pytest.raises(OutputError) as raised:
        write_files({target: NEW})
    assert str(raised.value) == f"cannot write {target}: file too large"
    assert list(target.parent.iterdir()) == [target] and target.read_bytes() == OLD


def test_no_file_is_touched_when_one_of_them_cannot_be_whole(tmp_path):
    first, mark = tmp_path / "first", tmp_path / "mark"
    first.write_bytes(OLD), mark.write_bytes(OLD)
    with no_longer_than(1000), pytest.raises(OutputError, match="cannot write .*/mark"):
        write_files({first: b"small", mark: NEW})
    assert first.read_bytes() == mark.read_bytes() == OLD
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), KeyboardInterrupt()])
def test_a_fault_at_any_step_leaves_the_old_file(target, monkeypatch, step, error):
    def fails(*_):
        raise error

    monkeypatch.setattr(outputs.os, step, fails)
    with pytest.raises((OutputError, KeyboardInterrupt)) as raised:
        write_files({target: NEW})
    assert target.read_bytes() == OLD and list(target.parent.iterdir()) == [target]
    assert isinstance(error, KeyboardInterrupt) or str(raised.value) == f"cannot write {target}: no space left on device"


def test_the_mark_goes_before_the_first_file_and_comes_after_the_last(tmp_path, monkeypatch):
    first, mark, seen = tmp_path / "first", tmp_path / "mark", []
    first.write_bytes(OLD), mark.write_bytes(OLD)
    replace = os.replace

    def watched(part, path):
        seen.append((Path(path).name, mark.exists(), first.read_bytes() == OLD))
        replace(part, path)

    monkeypatch.setattr(outputs.os, "replace", watched)
    write_files({first: NEW, mark: NEW})
    assert seen == [("first", False, True), ("mark", False, False)]
    assert mark.read_bytes() == NEW


def test_pieces_make_a_file_and_one_that_cannot_be_made_leaves_the_old_one(target):
    def pieces(last):
        yield NEW
        yield last()

    write_files({target: pieces(lambda: b"more")})
    assert target.read_bytes() == NEW + b"more"
    with pytest.raises(ZeroDivisionError):
        write_files({target: pieces(lambda: bytes(1 // 0))})
    assert target.read_bytes() == NEW + b"more" and list(target.parent.iterdir()) == [target]


def test_what_is_no_file_is_written_to(tmp_path):
    read, write = os.pipe()
    write_files({Path(f"/dev/fd/{write}"): b"through"})
    os.close(write)
    assert os.read(read, 100) == b"through"
    os.close(read)
    with pytest.raises(OutputError, match="cannot write /dev/full: no space left on device"):
        write_files({Path("/dev/full"): NEW})
    assert not Path("/dev/full").is_file()
    with pytest.raises(OutputError, match="is a directory"):
        write_files({tmp_path: NEW})


def test_what_a_killed_process_has_left_goes_with_the_next_attempt(target):
    child = os.fork()
    if child == 0:
        outputs.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
        write_files({target: NEW})
        os._exit(0)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
    assert target.read_bytes() == OLD and len(list(target.parent.iterdir())) == 2
    write_files({target: NEW})
    assert target.read_bytes() == NEW and list(target.parent.iterdir()) == [target]


def test_a_file_that_another_process_is_writing_is_left_alone(target):
    with outputs._written_beside(target, [NEW]) as other:
        write_files({target: b"mine"})
        assert other.read_bytes() == NEW
    assert target.read_bytes() == b"mine"


def test_an_input_is_known_by_every_name(target, tmp_path):
    soft, hard, other = tmp_path / "soft", tmp_path / "hard", tmp_path / "other"
    soft.symlink_to(target), hard.hardlink_to(target)
    for name in (target, soft, hard, tmp_path / "." / "out.bin"):
        with pytest.raises(HnavError, match="is read by this command, which would overwrite it: name another file"):
            refuse_overwriting([other, name], [target])
    with pytest.raises(HnavError, match="are one file: name two"):
        refuse_overwriting([other, tmp_path / "." / "other"], [target])
    refuse_overwriting([other, None, Path("/dev/null"), Path("/dev/null")], [target, None])


# --------------------------------------------------------------------------------------------- commands


def test_filter_refuses_to_overwrite_its_recording(tmp_path):
    recording, link = tmp_path / "x.csv", tmp_path / "link.csv"
    recording.write_text("t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,-9.81\n0.01,0,0,0,0,0,-9.81\n")
    link.symlink_to(recording)
    before = recording.read_bytes()
    for out in (recording, link):
        done = hnav("filter", recording, "--out", out)
        assert (done.returncode, recording.read_bytes()) == (2, before)
        assert done.stderr == f"hnav: {out} is read by this command, which would overwrite it: name another file\n"
    for options in (["--out", recording], ["--picture", recording]):
        assert "which would overwrite it" in hnav("calibrate", recording, *options).stderr
    assert recording.read_bytes() == before


def test_a_folder_of_results_is_never_overwritten_by_what_is_made_of_it(tmp_path):
    for name in ("run.json", "signals.h5"):
        (tmp_path / name).write_bytes(OLD)
        for command, said in (("certify", "which would overwrite it"), ("report", "a page is HTML")):
            done = hnav(command, tmp_path, "--out", tmp_path / name)
            assert done.returncode == 2 and said in done.stderr, done.stderr
        assert (tmp_path / name).read_bytes() == OLD


def test_each_command_that_writes_a_page_names_it_html(tmp_path):
    asked = {name: ["x.csv", "--report"] for name in ("filter", "noise", "observe", "calibrate")}
    asked |= {"compare": ["x.csv", "y.csv", "--report"], "report": ["x.csv", "--out"]}
    for command, arguments in asked.items():
        page = tmp_path / f"{command}.pdf"
        done = hnav(command, *arguments, page)
        assert (done.returncode, done.stderr) == (2, f"hnav: {page}: a page is HTML: name it .html\n")
        assert not page.exists()


def test_a_full_device_is_one_line(tmp_path):
    recording = tmp_path / "x.csv"
    recording.write_text("t_s,gx,gy,gz,ax,ay,az\n0,0.01,0,0,0,0,-9.81\n0.01,0,0.01,0,0,0,-9.81\n")
    done = hnav("filter", recording, "--out", "/dev/full")
    assert (done.returncode, done.stderr) == (2, "hnav: cannot write /dev/full: no space left on device\n")


def test_thousands_of_outputs_are_held_against_thousands_of_inputs_at_once(tmp_path):
    inputs = [tmp_path / f"in{i}.csv" for i in range(3000)]
    made = [tmp_path / f"out{i}.csv" for i in range(3000)]
    inputs[-1].write_text("x")
    begin_s = time.perf_counter()
    refuse_overwriting(made, inputs)
    assert time.perf_counter() - begin_s < 5
    made[-1].symlink_to(inputs[-1])
    with pytest.raises(HnavError, match="is read by this command"):
        refuse_overwriting(made, inputs)


def test_the_package_needs_no_module_that_windows_lacks():
    """Every module of hnav is imported without them."""
    code = """
import importlib, pkgutil, sys
sys.modules.update(dict.fromkeys(("fcntl", "termios", "resource", "grp", "pwd", "pty", "tty")))
import hnav
for module in pkgutil.walk_packages(hnav.__path__, "hnav."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
