"""Runs a foreign binary in a child process, so that the parent can report its crash."""

from __future__ import annotations

import atexit
import io
import os
import shutil
import signal
import sys
import tempfile
import time

from hnav.cli.words import Interrupted, UsageError
from hnav.io.outputs import temporary_folder

PATIENCE_S, STEP_S = 2.0, 0.05
"""Seconds after an interrupt until a binary that does not respond is killed."""


def watched(binary: str, remedy: str) -> None:
    """From here on a child goes on, and this process waits for it and ends as it does. Raises UsageError here when the binary ends the
    child, by a crash or by calling exit, and Interrupted when it had to be killed after an interrupt.

    Where there is no fork, as under Windows, or output is kept in memory, all goes on in this process.
    """
    if not hasattr(os, "fork") or not _writes_to_files():
        return
    sys.stdout.flush()
    sys.stderr.flush()
    # The child unpacks into this folder, so that nothing outlives a crash.
    unpacked = temporary_folder("hnav_watched_")
    ended_by_itself, at_end = os.pipe()
    child = os.fork()
    if child == 0:
        tempfile.tempdir = str(unpacked)
        atexit.register(os.write, at_end, b".")  # not called where the binary calls exit
        return
    os.close(at_end)
    try:
        code = _ended(child)
    except KeyboardInterrupt:
        code = _interrupted(child, binary)
    finally:
        shutil.rmtree(unpacked, ignore_errors=True)
    if code < 0:
        raise UsageError(f"{binary} crashed ({signal.Signals(-code).name}), and took its process with it: {remedy}")
    if not os.read(ended_by_itself, 1):
        raise UsageError(f"{binary} called exit({code}), and took its process with it: {remedy}")
    sys.exit(code)


def _interrupted(child: int, binary: str) -> int:
    """The exit code of a child that ends normally. An interrupt from the keyboard reaches both processes, one from kill only
    this process.
    """
    os.kill(child, signal.SIGTERM)
    for _ in range(round(PATIENCE_S / STEP_S)):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(STEP_S)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise Interrupted(f"{binary} did not come back within {PATIENCE_S:g} s of the interrupt, and was killed; nothing was written")


def _writes_to_files() -> bool:
    try:
        return sys.stdout.fileno() >= 0 and sys.stderr.fileno() >= 0
    except (AttributeError, io.UnsupportedOperation, ValueError):
        return False


def _ended(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
