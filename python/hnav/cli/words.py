"""Errors of the command line: replaces Python arguments in messages of the library by the options that users type."""

from __future__ import annotations

import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, cast

import typer

from hnav.errors import HnavError

if TYPE_CHECKING:
    from hnav.io.findings import Finding

# Arguments of the library, and the options for them. All others are options of a filter: --set NAME=VALUE.
OPTIONS = {
    "filter": "--filter", "engine": "--engine", "preset": "--preset", "step_s": "--step", "stop_s": "--stop", "mag_unit": "--mag-unit",
    "unit": "--mag-unit", "gyro_unit": "--gyro-unit", "accel_unit": "--accel-unit", "time_unit": "--time-unit", "format": "--format",
    "columns": "--columns", "axes": "--axes", "rate_hz": "--rate", "drop_repeats": "--drop-repeats", "fixes_late_s": "--fixes-late", "hemisphere": "--hemisphere",
    "navigation_frame": "--frame", "body": "--body", "experiment": "--experiment", "begin_s": "--from", "align": "--align", "delta_s": "--delta", "seed": "--seed", "runs": "--runs", "workers": "--workers", "settings": "--set", "fmi_version": "--fmi", "period_s": "--period",
}  # fmt: skip


# Python arguments within messages of readers and checks.
IN_A_LINE = (
    (
        re.compile(r"\b(gyro_unit|accel_unit|mag_unit|time_unit|rate_hz|drop_repeats|fixes_late_s)\b"),
        lambda match: OPTIONS[match.group(1)],
    ),
    (re.compile(r"\balign (?=clock)"), lambda match: "--align "),
    (re.compile(r"\bcolumns (?=\w+=)"), lambda match: "--columns "),
    (re.compile(r'\bhemisphere "(\w+)"'), lambda match: f"--hemisphere {match.group(1)}"),
    (re.compile(r"\b(?=(?:(?:gyro|accel|mag)_range_\w+|gyro_hold)=)"), lambda match: "--set "),
)


INTERRUPTED = 130  # exit code
# Click's UsageError, which newer versions of typer contain.
MISTYPED = cast(type[Exception], typer.BadParameter.__bases__[0])


class UsageError(Exception):
    """The request of the user cannot be carried out; the text states why."""


class Interrupted(UsageError):
    """The user interrupted the command; the text states which results are kept."""


def of_the_command_line(error: HnavError) -> str:
    """The text of an error with its leading argument replaced by the name of the option."""
    argument = error.argument if error.argument and str(error).startswith(error.argument) else ""
    rest = str(error)[len(argument) :]
    if error.status == "no data":
        rest = with_options(rest)
    if not argument:
        return rest
    if argument not in OPTIONS:
        return f"--set {argument}{rest.replace(' = ', '=', 1) if rest.startswith(' = ') else rest}"
    return f"{OPTIONS[argument]} {rest[3:]}" if rest.startswith(" = ") else f"{OPTIONS[argument]}{rest}"


def with_options(text: str) -> str:
    """A line of a reader or a check, with options instead of Python arguments."""
    for pattern, option in IN_A_LINE:
        text = pattern.sub(option, text)
    return text


def finding_line(finding: Finding) -> str:
    """A finding about a recording in one line, with an option as its remedy."""
    cures = [f"use {OPTIONS[finding.argument]} {finding.value}".removesuffix(" yes")] if finding.argument else []
    cures += [with_options(finding.advice)] if finding.advice else []
    return f"{finding.sensor}: {finding.message}" + (f"; {'; '.join(cures)}" if cures else "")


def answer(name: str, command: Callable[..., Any], arguments: Sequence[str] | None = None) -> None:
    """Runs a command of typer; an error that the user can correct becomes one line on stderr and exit code 2."""
    try:
        with tidy_end():
            code = command(arguments, standalone_mode=False)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except MISTYPED as error:
        print(f"{name}: {mistyped(error, name)}", file=sys.stderr)
        sys.exit(2)
    except (UsageError, HnavError, OSError, MemoryError) as error:
        print(f"{name}: {in_one_line(error)}", file=sys.stderr)
        sys.exit(INTERRUPTED if isinstance(error, Interrupted) else 2)
    if code == INTERRUPTED:
        print(f"{name}: interrupted", file=sys.stderr)
    if code:
        sys.exit(code)


def mistyped(error: Any, name: str) -> str:
    """The fault in the words of a command, and where they are explained."""
    text = error.format_message().rstrip(".")
    asked = error.ctx.command_path if error.ctx else name
    return f"{text[:1].lower()}{text[1:]}; see {asked} --help"


@contextmanager
def tidy_end() -> Iterator[None]:
    """Treats SIGTERM like an interrupt from the keyboard: finished files stay, unfinished ones are removed."""
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
    """The fault in the user's terms: their arguments, the disk, or the memory."""
    if isinstance(error, HnavError):
        return of_the_command_line(error)
    if isinstance(error, OSError):
        return f"{error.filename or 'standard output'}: {(error.strerror or str(error)).lower()}"
    if isinstance(error, MemoryError):
        return "the memory of this machine is not enough: take fewer samples, a coarser step or an earlier stop"
    return str(error)
