"""Commands in processes of their own that are killed, or whose disk is full or read-only."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

from hnav.cli.app import main

CAPABILITY_VERSION, CAP_DAC_OVERRIDE = 0x20080522, 1  # linux/capability.h


@dataclass
class Child:
    """A command at work."""

    process: int
    said: Path  # what it writes to standard error

    def ended(self) -> bool:
        return os.waitid(os.P_PID, self.process, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def wait(self) -> int:
        """Its exit code; negative is the signal that ended it."""
        return os.waitstatus_to_exitcode(os.waitpid(self.process, 0)[1])

    def kill(self, with_signal: int) -> int:
        os.kill(self.process, with_signal)
        return self.wait()


def start(arguments: list[str], said: Path, before: Callable[[], None] = lambda: None) -> Child:
    """Forks, because hnav takes a second to load and that is not what is to be interrupted. before: done in the child."""
    process = os.fork()
    if process:
        return Child(process, said)
    code = 1
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666), 2)
        sys.stdout, sys.stderr = (os.fdopen(descriptor, "w", buffering=1) for descriptor in (1, 2))
        before()
        main(arguments)
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except KeyboardInterrupt:
        pass
    except BaseException as error:
        os.write(2, f"Traceback: {error!r}\n".encode())
    finally:
        os._exit(code)


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


def wait_for_writing(child: Child, folder: Path) -> None:
    """Until something new stands in the folder, or the command has ended."""
    before = set(os.listdir(folder))
    while not child.ended() and set(os.listdir(folder)) <= before:
        time.sleep(1e-4)
