"""How the command line says what went wrong: the library speaks of Python's arguments, users typed options."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from hnav.errors import HnavError

# Arguments of the library, and the options that stand for them. What is neither is an option of a filter: --set NAME=VALUE.
OPTIONS = {
    "filter": "--filter", "engine": "--engine", "preset": "--preset", "step_s": "--step", "stop_s": "--stop", "mag_unit": "--mag-unit",
    "unit": "--mag-unit", "navigation_frame": "--frame", "experiment": "--experiment", "begin_s": "--from", "seed": "--seed", "runs": "--runs", "workers": "--workers", "settings": "--set",
}  # fmt: skip


class UsageError(Exception):
    """What the user typed cannot be done; the text says why."""


def of_the_command_line(error: HnavError) -> str:
    """The text of an error in which the argument at its head bears the name of its option."""
    text, argument = str(error), error.argument
    if not argument or not text.startswith(argument):
        return text
    rest = text[len(argument) :]
    if argument not in OPTIONS:
        return f"--set {argument}{rest.replace(' = ', '=', 1) if rest.startswith(' = ') else rest}"
    return f"{OPTIONS[argument]} {rest[3:]}" if rest.startswith(" = ") else f"{OPTIONS[argument]}{rest}"


def answer(name: str, command: Callable[..., Any], arguments: Sequence[str] | None = None) -> None:
    """Runs a command; what the user can mend becomes one line on stderr and exit code 2."""
    try:
        with tidy_end():
            command(arguments)
    except KeyboardInterrupt:  # before typer listens to it
        print(f"{name}: interrupted", file=sys.stderr)
        sys.exit(130)
    except (UsageError, HnavError, OSError, MemoryError) as error:
        print(f"{name}: {in_one_line(error)}", file=sys.stderr)
        sys.exit(2)


@contextmanager
def tidy_end() -> Iterator[None]:
    """SIGTERM is an interrupt as from the keyboard: what is unfinished goes, what is finished stays."""
    if threading.current_thread() is not threading.main_thread():  # signals are for the main thread alone
        yield
        return

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def in_one_line(error: UsageError | HnavError | OSError | MemoryError) -> str:
    """What went wrong in the user's words: their arguments, the disk, or the memory."""
    if isinstance(error, HnavError):
        return of_the_command_line(error)
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'}: {(error.strerror or str(error)).lower()}"
    if isinstance(error, MemoryError):
        return "the memory of this machine is not enough: take fewer samples, a coarser step or an earlier stop"
    return str(error)
