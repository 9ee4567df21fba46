"""A foreign binary may take its process with it: then another one is there to say so."""

from __future__ import annotations

import io
import os
import shutil
import signal
import sys
import tempfile

from hnav.cli.words import UsageError
from hnav.io.outputs import temporary_folder


def watched(binary: str, remedy: str) -> None:
    """From here on a child goes on, and this process waits for it and ends as it does. Raises UsageError here when the child crashes.

    Where there is no fork, as under Windows, or output is kept in memory, all goes on in this process.
    """
    if not hasattr(os, "fork") or not _writes_to_files():
        return
    sys.stdout.flush()
    sys.stderr.flush()
    # What the child unpacks lies in here: it does not outlive a crash.
    unpacked = temporary_folder("hnav_watched_")
    child = os.fork()
    if child == 0:
        tempfile.tempdir = str(unpacked)
        return
    try:
        code = _ended(child)
    except KeyboardInterrupt:
        # From the keyboard it comes to both, from a kill to this one alone.
        os.kill(child, signal.SIGTERM)
        code = _ended(child)
    finally:
        shutil.rmtree(unpacked, ignore_errors=True)
    if code >= 0:
        sys.exit(code)
    raise UsageError(f"{binary} crashed ({signal.Signals(-code).name}), and took its process with it: {remedy}")


def _writes_to_files() -> bool:
    try:
        return sys.stdout.fileno() >= 0 and sys.stderr.fileno() >= 0
    except (AttributeError, io.UnsupportedOperation, ValueError):
        return False


def _ended(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
