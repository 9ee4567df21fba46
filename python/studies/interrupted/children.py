"""Commands in processes of their own that are killed, or whose disk is full or read-only."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from io import StringIO
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

from hnav.cli.app import main

CAPABILITY_VERSION, CAP_DAC_OVERRIDE = 0x20080522, 1  # linux/capability.h


def start(arguments: list[str], said: Path, before: Callable[[], None] = lambda: None) -> BaseProcess:
    """Forks, because hnav takes a second to load and that is not what is to be interrupted. said: what it writes to standard error; before:
    done in the child."""
    child = get_context("fork").Process(target=_run, args=(arguments, said, before))
    child.start()
    return child


def _run(arguments: list[str], said: Path, before: Callable[[], None]) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666), 2)
    sys.stdout, sys.stderr = (os.fdopen(descriptor, "w", buffering=1) for descriptor in (1, 2))
    before()
    with suppress(KeyboardInterrupt):
        main(arguments)


def run(arguments: list[str], said: Path, before: Callable[[], None] = lambda: None) -> int | None:
    """The exit code of a command that is not interrupted."""
    child = start(arguments, said, before)
    child.join()
    return child.exitcode


def kill(child: BaseProcess, with_signal: int) -> None:
    if child.is_alive() and child.pid:
        os.kill(child.pid, with_signal)
    child.join()


def run_here(arguments: list[str]) -> None:
    """In this process, silently; what a user would mend ends the study."""
    with redirect_stdout(StringIO()):
        try:
            main(arguments)
        except SystemExit as end:
            if end.code:
                raise


def full_after(size: int) -> Callable[[], None]:
    """No file of the child becomes longer than that."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def without_privilege() -> None:
    """For root no folder is read-only, so it gives up its right to write everywhere (capabilities(7))."""
    libc = ctypes.CDLL(None, use_errno=True)
    header, data = (ctypes.c_uint32 * 2)(CAPABILITY_VERSION, 0), (ctypes.c_uint32 * 6)()
    if libc.capget(header, data) == 0:
        data[0] &= ~(1 << CAP_DAC_OVERRIDE)  # of those in effect
        libc.capset(header, data)


def wait_for_writing(child: BaseProcess, folder: Path) -> None:
    """Until something new stands in the folder, or the command has ended."""
    before = set(os.listdir(folder))
    while child.is_alive() and set(os.listdir(folder)) <= before:
        time.sleep(1e-4)
