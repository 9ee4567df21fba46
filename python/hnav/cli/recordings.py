"""Recordings as commands take them: read as the user says, and checked."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hnav.cli.words import UsageError, told
from hnav.io.plausibility import Finding
from hnav.io.readers import read
from hnav.io.recordings import Recording


def pairs(option: str, texts: list[str] | None) -> dict[str, str]:
    """NAME=VALUE each, to values by name. Raises UsageError."""
    found = {}
    for text in texts or []:
        name, separator, value = text.partition("=")
        if not (separator and name.strip() and value.strip()):
            raise UsageError(f"{option} {text}: write NAME=VALUE")
        found[name.strip()] = value.strip()
    return found


def read_told(path: Path, options: Mapping[str, Any]) -> Recording:
    """The recording, with the options of the command line by the arguments of hnav.read. Raises HnavError."""
    return read(path, **{**options, **{name: pairs(f"--{name}", options[name]) for name in ("columns", "axes")}})


def lines_of(findings: list[Finding]) -> list[str]:
    """A line for each finding: its level, what was found, and the option that mends it."""
    return [f"{finding.level}: {told(finding)}" for finding in findings]


def warnings_of(path: Path, findings: list[Finding], strict: bool) -> list[str]:
    """A line for each warning; raises UsageError for an error, or with strict for a warning."""
    alarms = [finding for finding in findings if finding.level != "note"]
    if any(finding.level == "error" or strict for finding in alarms):
        more = f" (and {len(alarms) - 1} more: hnav check {path})" if len(alarms) > 1 else ""
        raise UsageError(f"{path}: {told(alarms[0])}{more}")
    return [f"warning: {path.name}: {told(finding)}" for finding in alarms]


def warn(lines: list[str]) -> None:
    """To stderr, where they are no part of what a command answers."""
    for line in lines:
        print(line, file=sys.stderr)
