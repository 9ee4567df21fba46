"""hnav options: the options of a filter with unit, default, range and meaning."""

from __future__ import annotations

import json
import textwrap
from typing import Annotated, Any

import typer

from hnav.cli.console import console, say
from hnav.cli.parameters import FilterOrIns
from hnav.cli.words import UsageError
from hnav.filters.options import PRESETS, option_table
from hnav.native.options import OptionInfo

FEW = 5  # options up to this number are printed in full


def command(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[WORD]...", help="Show the options that have these words in name, unit or text")
    ] = None,
    filter: FilterOrIns = "ahrs",
    as_json: Annotated[bool, typer.Option("--json", help="As JSON, with the reasons of the defaults")] = False,
) -> None:
    words = words or []
    if len(words) == 1 and words[0].lower() in PRESETS:
        words, filter = [], words[0].lower()
    everything = list(option_table(filter).values())
    found = sorted((info for info in everything if matches(info, words)), key=lambda info: info.advanced)
    if as_json:
        typer.echo(json.dumps([described(info) for info in found], indent=1))
        return
    if not found:
        raise UsageError(f"no option of {filter} has {' and '.join(words)} in its name or text; hnav options lists them all")
    (print_all if console.is_terminal else table)(filter, found)


def table(_: str, found: list[OptionInfo]) -> None:
    """One line each, for tools such as grep."""
    widths = [max(len(cells(info)[i]) for info in found) for i in range(3)]
    for info in found:
        first = "  ".join(f"{cell:<{width}}" for cell, width in zip(cells(info), widths))
        say(f"{first}  {info.description}")


def print_all(filter: str, found: list[OptionInfo]) -> None:
    """For readers: two sections, as wide as the terminal."""
    for advanced, head in ((False, "to look at first"), (True, "advanced")):
        of_kind = [info for info in found if info.advanced == advanced]
        if of_kind:
            console.print(f"[bold]{filter}: {head}[/bold]", highlight=False)
        for info in of_kind:
            print_option(info, whole=len(found) <= FEW)


def matches(info: OptionInfo, words: list[str]) -> bool:
    """Whether every word occurs in the text shown of an option, ignoring case."""
    text = " ".join([info.name, info.group, info.unit, info.description, *info.choices, *info.choice_descriptions]).lower()
    return all(word.lower() in text for word in words)


def cells(info: OptionInfo) -> tuple[str, str, str]:
    """Name, default with its unit, and permitted values."""
    values = info.default if isinstance(info.default, tuple) else (info.default,)
    default = ",".join(value if isinstance(value, str) else f"{value:g}" for value in values)
    allowed = ", ".join(info.choices) or f"{info.min:g} to {info.max:g}"
    return info.attribute, f"{default} {info.unit}".rstrip(), allowed


def print_option(info: OptionInfo, whole: bool) -> None:
    """An option on two or three lines, its name never cut; whole: with the reason for the default."""
    name, default, allowed = cells(info)
    head = f"{name} = {default}"
    lines = [f"  {head}  ({allowed})"]
    if len(lines[0]) > console.width:
        lines = [f"  {head}", *textwrap.wrap(f"({allowed})", console.width, initial_indent=" " * 6, subsequent_indent=" " * 6)]
    texts = [info.description]
    if whole:
        texts += [f"{choice}: {meaning}" for choice, meaning in zip(info.choices, info.choice_descriptions)]
        texts += [f"Default: {info.reason}"] if info.reason else []
    for text in texts:
        lines += textwrap.wrap(text, console.width, initial_indent=" " * 6, subsequent_indent=" " * 6)
    for line in lines:
        say(line)


def described(info: OptionInfo) -> dict[str, Any]:
    """An option for other programs."""
    choices = dict(zip(info.choices, info.choice_descriptions))
    allowed = {"choices": choices} if choices else {"min": info.min, "max": info.max}
    return {
        "name": info.attribute, "group": info.group, "unit": info.unit, "default": info.default, **allowed,
        "description": info.description, "reason": info.reason, "advanced": info.advanced,
    }  # fmt: skip
