"""A lock on an open file, held until it is closed or the process ends."""

from __future__ import annotations

import sys


def lock(descriptor: int) -> None:
    """Raises BlockingIOError when another process holds the lock, another OSError where the file system has no locks.

    Windows has no such locks, but a file that a process has open cannot be removed there.
    """
    if sys.platform != "win32":
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
