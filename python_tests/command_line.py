"""Commands as users type them."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from collections.abc import Callable
from typing import NamedTuple

from hnav.cli.app import main


class Answer(NamedTuple):
    """Exit status and output of a command."""

    returncode: int
    stdout: str
    stderr: str


def hnav_process(*arguments: object) -> Answer:
    """hnav in a process of its own."""
    done = subprocess.run([sys.executable, "-m", "hnav", *map(str, arguments)], capture_output=True, text=True, check=False)
    return Answer(done.returncode, done.stdout, done.stderr)


def hnav(*arguments: object) -> Answer:
    """hnav in this process."""
    return answered(main, *arguments)


def answered(main: Callable[[list[str]], None], *arguments: object) -> Answer:
    """The main of hnav or of a study."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    return Answer(code, out.getvalue(), err.getvalue())
