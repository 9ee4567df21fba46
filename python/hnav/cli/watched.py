"""A foreign binary may take its process with it: then another one is there to say so."""

from __future__ import annotations

import io
import os
import signal
import sys

from hnav.cli.words import UsageError


def watched(binary: str, remedy: str) -> None:
    """From here on a child goes on, and this process waits for it and ends as it does. Raises UsageError here when the child crashes.

    Where there is no fork, as under Windows, or output is kept in memory, all goes on in this process.
    """
    if not hasattr(os, "fork") or not _writes_to_files():
        return
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        return
    try:
        code = _ended(child)
    except KeyboardInterrupt:
        # From the keyboard it comes to both, from a kill to this one alone.
        os.kill(child, signal.SIGTERM)
        code = _ended(child)
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
