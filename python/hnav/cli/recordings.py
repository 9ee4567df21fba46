"""Recordings as commands take them: read as the user says, and checked."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
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


def read_told(path: Path, columns: list[str] | None = None, axes: list[str] | None = None, **told_units: Any) -> Recording:
    """The recording, with the options of the command line; the others as of hnav.read."""
    return read(path, columns=pairs("--columns", columns), axes=pairs("--axes", axes), **told_units)


def read_plausible(
    path: Path, hemisphere: str | None, strict: bool, options: Mapping[str, Any], untold: Collection[str] = ()
) -> Recording:
    """The recording. Warnings go to stderr; an error, or with strict a warning, raises UsageError.

    options: of read_told. untold: codes of findings that do not matter here.
    """
    data = read_told(path, **options)
    refuse(path, [finding for finding in data.check(hemisphere) if finding.code not in untold], strict)
    return data


def refuse(path: Path, findings: list[Finding], strict: bool) -> None:
    """Says what was found, and raises UsageError for an error, or with strict for a warning."""
    errors = [finding for finding in findings if finding.level == "error"]
    warnings = [finding for finding in findings if finding.level == "warning"]
    worst = errors or (warnings if strict else [])
    if worst:
        more = f" (and {len(errors + warnings) - 1} more: hnav check {path})" if len(errors + warnings) > 1 else ""
        raise UsageError(f"{path}: {told(worst[0])}{more}")
    for finding in warnings:
        print(f"warning: {told(finding)}", file=sys.stderr)
