"""hnav systems: the systems of hnav simulate, with the scenarios and grades of each."""

from __future__ import annotations

import json
import textwrap
from typing import Annotated, Any

import typer

from hnav.cli.completion import system_names
from hnav.cli.console import console, say
from hnav.cli.parameters import AllowOutside
from hnav.cli.words import UsageError
from hnav.systems.ssp_reader import known_systems, read_system, system_path


def command(
    system: Annotated[
        str | None,
        typer.Argument(metavar="[SYSTEM]", help="Name, .ssp file or folder; without it all by name", autocompletion=system_names),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="As JSON")] = False,
    allow_outside: AllowOutside = False,
) -> None:
    known = known_systems()
    if system is None and not known:
        raise UsageError("there are no systems yet: ./run fmus makes them, or set HNAV_SYSTEMS to their folder")
    found = [described(name, allow_outside) for name in ([system] if system is not None else sorted(known))]
    if as_json:
        typer.echo(json.dumps(found if system is None else found[0], indent=1))
        return
    for about in found:
        print_system(about, whole=system is not None)
    if system is None:
        say("hnav systems NAME lists scenarios and grades; hnav simulate NAME runs it")


def described(system: str, allow_outside: bool) -> dict[str, Any]:
    """A system for readers and programs."""
    with read_system(system_path(system), allow_outside) as read:
        return {
            "name": system, "description": read.description, "stop_s": read.stop_s, "step_s": read.step_s,
            "components": {component.name: component.fmu.stem for component in read.components.values()},
            "scenarios": {name: chosen.description for name, chosen in read.scenarios.items()},
            "grades": {name: chosen.description for name, chosen in read.grades.items()},
        }  # fmt: skip


def print_system(about: dict[str, Any], whole: bool) -> None:
    """A system on two lines, or with all its choices."""
    lines(about["name"], about["description"])
    times = [f"{about[key]:g} s{what}" for key, what in (("stop_s", ""), ("step_s", " a step")) if about[key] is not None]
    counts = [f"{len(about[kind])} {kind}" for kind in ("components", "scenarios", "grades") if about[kind]]
    say(f"    {', '.join(times + counts)}")
    if not whole:
        return
    say(f"  components (--set COMPONENT.PARAMETER=VALUE): {', '.join(about['components'])}")
    for kind in ("scenario", "grade"):
        if about[f"{kind}s"]:
            say(f"  {kind}s (--{kind} NAME)")
        for name, text in about[f"{kind}s"].items():
            lines(f"    {name}", text, 26)


def lines(name: str, text: str, column: int = 12) -> None:
    """A name and its description, wrapped on a terminal and on one line in a pipe."""
    head = f"{name:<{column}}" if len(name) < column else f"{name}  "
    if not console.is_terminal:
        say(f"{head}{text}".rstrip())
        return
    for line in textwrap.wrap(text, console.width, initial_indent=head, subsequent_indent=" " * column) or [head.rstrip()]:
        say(line)
